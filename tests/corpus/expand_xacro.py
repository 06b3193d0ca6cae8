"""Xacro of ROS as the peer: run by an interpreter that has it (`pip install xacro==2.1.1`), one file a line.

PYTHON expand_xacro.py < lines: each line a JSON list [path, workspace, {argument: value}]; answers a JSON list
[URDF, ""] or [null, reason]. Packages are looked up in the workspace, a folder with a link for each of them.
"""

import json
import os
import sys
import types


def main():
    """Answer line by line; what xacro prints goes to the error stream."""
    import xacro

    answers, sys.stdout = sys.stdout, sys.stderr
    for line in sys.stdin:
        path, workspace, arguments = json.loads(line)
        index.workspace = workspace
        try:
            answer = [xacro.process_file(path, mappings=arguments).toxml(), ""]
        except Exception as error:
            answer = [None, f"{type(error).__name__}: {error}"[:500]]
        print(json.dumps(answer), file=answers, flush=True)


def share_directory(package):
    """What ROS answers from its index of packages."""
    folder = os.path.join(index.workspace, package)
    if not os.path.isdir(folder):
        raise LookupError(f"package {package} not found")
    return os.path.realpath(folder)


index = types.ModuleType("ament_index_python.packages")
index.get_package_share_directory = share_directory
sys.modules["ament_index_python"] = types.ModuleType("ament_index_python")
sys.modules["ament_index_python.packages"] = index

if __name__ == "__main__":
    main()
