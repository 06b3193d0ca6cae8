// All configurations of the tip's pose by every method that Python has: elimination, search, families of redundant arms.

import { view } from "page/core/views.js";
import { hereOf } from "page/core/state.js";
import { quaternionOf } from "page/core/rotations.js";
import { element, number, sentence } from "page/views/elements.js";

view({
  name: "configurations",
  order: 35,
  mount(place, { store, words, link }) {
    const said = element("p", { class: "lines", role: "status" }), list = element("div", { class: "branches", id: "configurations" });
    const find = element("button", { type: "button", class: "quiet", id: "find", onclick: () => ask() }, sentence(words, "find"));
    place.append(element("p", { class: "soft" }, sentence(words, "configurations_about")), element("div", { class: "buttons" }, find), said, list);

    async function ask() {
      const q = hereOf(store.state), T = Array.from(store.arm.kernels.forward_kinematics(q)[0]);
      find.disabled = true;
      said.replaceChildren(sentence(words, "finding"));
      try {
        const { status, data } = await link.transport.send("configurations", { position: [T[3], T[7], T[11]], quaternion: quaternionOf(T), q });
        show(status === 200 ? data : { rows: [], sentence: data.error });
      } catch {
        said.replaceChildren(sentence(words, "server_lost"));
      }
      find.disabled = false;
    }
    if (link.found) show(link.found);

    function show(found) {
      link.found = found;
      said.replaceChildren(words.isolated(found.sentence));
      list.replaceChildren(...found.rows.map((row) => {
        const name = element("span", {}, words.isolated(row)), values = element(
          "span", { class: "soft" }, element("bdi", { dir: "ltr" }, `(${row.q.map((value) => number(value, 2)).join(", ")})`)
        );
        return element(
          "button", { type: "button", disabled: !row.within, onclick: () => store.do("set_joints", { values: row.q }) }, element("i"), name,
          values
        );
      }));
    }
    return () => {};
  },
});
