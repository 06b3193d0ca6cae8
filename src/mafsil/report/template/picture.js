// One still robot, to be looked at from all sides.
const data = JSON.parse(document.getElementById("data").textContent);
try { new Replay(document.getElementById("scene"), data.scene).show(0); } catch (reason) { document.getElementById("no-scene").hidden = false; document.getElementById("scene").hidden = true; console.warn(String(reason)); }
