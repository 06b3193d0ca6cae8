// Whether the server is there, and how many windows share this arm.

import { view } from "page/core/views.js";
import { element, sentence } from "page/views/elements.js";

view({
  name: "server",
  tab: "code",
  order: 5,
  open: true,
  mount(place, { link, words, data }) {
    const line = element("p", { id: "server", role: "status" });
    place.append(line);
    let shown = "";
    return () => {
      const count = link.heard.get("windows")?.count ?? 1, refusal = link.heard.get("refusal");
      const key = !link.connected ? "server_lost" : refusal ? "server_refused" : "server_here";
      const now = JSON.stringify([key, count, refusal]);
      if (now === shown) return;
      shown = now;
      line.classList.toggle("wrong", key !== "server_here");
      line.replaceChildren(sentence(words, key, { count, robot: data.robot.name, reason: refusal?.[words.chosen] ?? "" }));
    };
  },
});
