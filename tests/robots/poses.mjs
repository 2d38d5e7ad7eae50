// Where the script of a report page places the links of a robot.
//
//     node poses.mjs PAGE < POSITIONS > POSES
//
// Reads a list of configurations: a list of a position for each joint of the page. Writes a list of the
// frames of all links for each: `q` (x, y, z, w) and `t`.

import { readFileSync } from "node:fs";

const page = readFileSync(process.argv[2], "utf8");
const between = (from, to) => page.split(from)[1].split(to)[0];
const data = JSON.parse(between('<script type="application/json" id="data">', "</script>"));
const functions = between("<script>\n", "// The page of a robot:");
const { posesOf, followed } = new Function("addEventListener", `${functions}; return { posesOf, followed };`)(() => {});

const configurations = JSON.parse(readFileSync(0, "utf8"));
const poses = configurations.map((positions) => {
  const moved = positions.map((position, index) => position - data.joints[index].reference);
  return posesOf(data.links, data.joints, followed(data.joints, moved));
});
console.log(JSON.stringify(poses));
