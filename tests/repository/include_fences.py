#!/usr/bin/env python3
"""Fails when a source file includes what its folder may not (STYLE: lcmtypes <- common <- {actors, learner, planner}
<- deploy; each engine in its own few folders). Usage: include_fences.py ROOT, or include_fences.py --self-test."""

import pathlib
import re
import sys
import tempfile

# Folder -> folders it may include. tests/ sees all.
FOLDERS = {
    "common": {"common"},
    "actors": {"common", "actors"},
    "learner": {"common", "learner"},
    "planner": {"common", "planner"},
    "deploy": {"common", "actors", "learner", "planner", "deploy"},
    "tests": {"common", "actors", "learner", "planner", "deploy", "tests"},
}

# (what an include of the engine looks like, path prefixes that may have it). The mirror of a path under tests/ may too.
ENGINES = {
    "LCM": (r"lcm/|cairn_lcm/", ["common/bus/"]),
    "ODE": (r"ode/", ["actors/sim/", "actors/vehicles/"]),
    "OMPL": (r"ompl/", ["planner/"]),
    "FCL": (r"fcl/", ["planner/"]),
    "protobuf": (r"google/protobuf/|.*\.pb\.h$", ["common/config/", "common/nn/", "learner/checkpoint/",
                                                 "learner/metrics/"]),
    "libxsmm": (r"libxsmm", ["common/nn/gemm."]),
    "libsodium": (r"sodium", ["common/bus/"]),
    "yaml-cpp": (r"yaml-cpp/", ["common/world/import/"]),
    "libpng": (r"png\.h$", ["common/world/import/"]),
    "pugixml": (r"pugixml", ["common/world/import/"]),
}

# Made by the build; not found from the repository root.
GENERATED = {"git_revision.h"}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)


def breaches_of_file(root, path):
    """Yields one line per include of `path` that breaks a rule."""
    top = path.parts[0]
    mirror = str(path).removeprefix("tests/")
    text = (root / path).read_text(encoding="utf-8")
    for match in INCLUDE.finditer(text):
        included = match.group(2)
        where = f"{path}:{text.count(chr(10), 0, match.start(2)) + 1}: includes {included}"
        engine = next((name for name, (pattern, _) in ENGINES.items() if re.match(pattern, included)), None)
        if engine and not mirror.startswith(tuple(ENGINES[engine][1])) and not (engine == "LCM" and top == "tests"):
            yield f"{where}: {engine} is for {', '.join(ENGINES[engine][1])} only"
        if match.group(1) == "<" or included.startswith("cairn_lcm/") or included in GENERATED:
            continue
        if included.split("/")[0] not in FOLDERS:
            yield f"{where}: quoted includes start at the repository root"
        elif included.split("/")[0] not in FOLDERS[top]:
            yield f"{where}: {top}/ may include {', '.join(sorted(FOLDERS[top]))} only"
        elif not included.endswith(".pb.h") and not (root / included).exists():
            yield f"{where}: no such file"


def breaches(root):
    files = (f for top in FOLDERS for f in sorted((root / top).rglob("*")) if f.suffix in {".h", ".cc"})
    return [line for f in files for line in breaches_of_file(root, f.relative_to(root))]


# A made-up tree: file -> (text, words of the breach it must give, or None).
SELF_TEST = {
    "common/core/a.h": ('#pragma once\n#include <vector>\n', None),
    "common/bus/bus.cc": ('#include <lcm/lcm-cpp.hpp>\n#include "cairn_lcm/echo_t.hpp"\n', None),
    "common/config/load.cc": ('#include "common/config/experiment.pb.h"\n', None),
    "common/nn/gemm.cc": ('#include <libxsmm.h>\n', None),
    "actors/sim/world.cc": ('#include <ode/ode.h>\n#include "common/core/a.h"\n', None),
    "tests/actors/sim/world_test.cc": ('#include <ode/ode.h>\n#include "common/core/a.h"\n', None),
    "deploy/main.cc": ('#include "common/core/a.h"\n', None),
    "common/core/up.cc": ('#include "actors/sim/world.cc"\n', "common/ may include"),
    "learner/sideways.cc": ('#include "planner/p.h"\n', "learner/ may include"),
    "planner/p.h": ('  #  include "deploy/main.cc"\n', "planner/ may include"),
    "learner/lcm.cc": ('#include <lcm/lcm-cpp.hpp>\n', "LCM is for"),
    "actors/types.cc": ('#include <cairn_lcm/echo_t.hpp>\n', "LCM is for"),
    "actors/environment.cc": ('#include <ode/ode.h>\n', "ODE is for"),
    "learner/plan.cc": ('#include <ompl/base/State.h>\n', "OMPL is for"),
    "common/world/hit.cc": ('#include <fcl/fcl.h>\n', "FCL is for"),
    "deploy/file.cc": ('#include <google/protobuf/message.h>\n', "protobuf is for"),
    "actors/file.cc": ('#include "common/config/experiment.pb.h"\n', "protobuf is for"),
    "common/nn/policy.cc": ('\n#include <libxsmm.h>\n', "libxsmm is for"),
    "deploy/key.cc": ('#include <sodium.h>\n', "libsodium is for"),
    "tests/learner/ode_test.cc": ('#include <ode/ode.h>\n', "ODE is for"),
    "common/world/import/png.cc": ('#include <png.h>\n', None),
    "common/world/map.cc": ('#include <yaml-cpp/yaml.h>\n', "yaml-cpp is for"),
    "actors/relative.cc": ('#include "../common/core/a.h"\n', "start at the repository root"),
    "actors/gone.cc": ('#include "common/core/gone.h"\n', "no such file"),
}


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, (text, _) in SELF_TEST.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        found = breaches(root)
    failures = []
    for name, (_, words) in SELF_TEST.items():
        lines = [line for line in found if line.startswith(name + ":")]
        if (words is None and lines) or (words is not None and (len(lines) != 1 or words not in lines[0])):
            failures.append(f"{name}: expected {words!r}, got {lines}")
    return failures


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    problems = self_test() if sys.argv[1] == "--self-test" else breaches(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(problems) or "ok")
    sys.exit(1 if problems else 0)
