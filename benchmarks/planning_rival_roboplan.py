"""roboplan's RRT-Connect on problems from a file; run by its own interpreter, for `planning.py --roboplan PYTHON`.

python benchmarks/planning_rival_roboplan.py PROBLEMS.json

The file holds the paths of a URDF and an SRDF, the group of joints, links that stand still, pairs that the other side
does not look at, and problems: obstacles, start and goal of all
coordinates. Prints a line of JSON with the version, then for every number on its input the path of that problem, as
rows of the group's coordinates, and its seconds. Obstacles are placed before the clock starts, as by the other side;
its options are its own but for the nodes (its 1,000 give up early), the clock, and steps of 0.02 along edges.
"""

import json
import sys
from contextlib import suppress
from itertools import combinations
from time import perf_counter

import numpy as np
import roboplan
from roboplan import core, rrt

COLOUR = np.array([0.5, 0.5, 0.5, 1.0])


def placed(scene: core.Scene, row: dict) -> None:
    """One obstacle, which the world carries."""
    w, x, y, z = np.array(row["quaternion_wxyz"]) / np.linalg.norm(row["quaternion_wxyz"])
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = row["position"]
    T = np.asfortranarray(T)
    name = row["name"]
    if row["kind"] == "box":
        scene.addBoxGeometry(name, "universe", core.Box(*row["size"]), T, COLOUR)
    elif row["kind"] == "sphere":
        scene.addSphereGeometry(name, "universe", core.Sphere(row["radius"]), T, COLOUR)
    else:
        scene.addCylinderGeometry(name, "universe", core.Cylinder(row["radius"], row["length"]), T, COLOUR)


def main(path: str, repeats: str) -> None:
    """Answer numbers of problems until the input ends: the first path, and the seconds of so many searches."""
    with open(path, encoding="utf-8") as file:
        data = json.load(file)
    with open(data["urdf"], encoding="utf-8") as file:
        urdf = file.read()
    with open(data["srdf"], encoding="utf-8") as file:
        srdf = file.read()
    print(json.dumps({"version": getattr(roboplan, "__version__", core.__version__)}), flush=True)
    for line in sys.stdin:
        problem = data["problems"][int(line)]
        scene = core.Scene("problem", core.loadUrdfSceneDescriptionFromXml(urdf))
        scene.importSrdf(srdf)
        scene.addGroup("arm", data["joints"])
        names = scene.getJointNames()
        everything = dict(zip(data["coordinates"], problem["start"], strict=True))
        scene.setJointPositions(np.array([everything[name] for name in names]))
        for row in problem["obstacles"]:
            placed(scene, row)
        # Obstacles may touch each other and what no joint moves, as on the other side.
        things = [row["name"] for row in problem["obstacles"]]
        allowed = list(combinations(things, 2)) + [(link, thing) for link in data["still"] for thing in things]
        scene.setCollisions(allowed + [tuple(pair) for pair in data["skipped"]], False)
        columns = [data["coordinates"].index(name) for name in data["joints"]]
        start, goal = (np.array(problem[end])[columns] for end in ("start", "goal"))
        options = rrt.RRTOptions("arm", max_nodes=1_000_000, max_planning_time=10.0, rrt_connect=True)
        options.collision_check_step_size = 0.02
        ends = [core.JointConfiguration(data["joints"], each) for each in (start, goal)]
        path, seconds = None, []
        for seed in range(int(repeats)):
            planner = rrt.RRT(scene, options)
            planner.setRngSeed(seed)
            begun = perf_counter()
            with suppress(RuntimeError):
                found = planner.plan(*ends)
                path = path or [row.tolist() for row in found.positions]
            seconds.append(perf_counter() - begun)
        print(json.dumps({"path": path, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
