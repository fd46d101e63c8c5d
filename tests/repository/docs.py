#!/usr/bin/env python3
"""Fails when the papers do not match the tree: a folder without its three-line README, a wire field without unit and
meaning, a message type that docs/messages.md or lcmtypes/README.md does not know, a function or test that the docs
name and nobody wrote, a link to nowhere, a derived option that docs/recipes.md does not have.
Usage: docs.py ROOT; docs.py ROOT --write brings the field tables of docs/messages.md up to date."""

import pathlib
import re
import sys

SOURCE_FOLDERS = ["lcmtypes", "common", "actors", "learner", "planner", "deploy", "tests"]


def folders_with_files(root):
    """Folders below the source folders that hold files of their own, relative to root."""
    for top in SOURCE_FOLDERS:
        for folder in [root / top, *sorted((root / top).rglob("*"))]:
            if folder.is_dir() and folder.name != "__pycache__" and any(f.is_file() for f in folder.iterdir()):
                yield folder.relative_to(root)


def readme_problems(root):
    for folder in folders_with_files(root):
        if folder.parts[0] == "tests" and (root / pathlib.Path(*folder.parts[1:])).is_dir() and len(folder.parts) > 1:
            continue  # tests/common/bus is explained where common/bus is
        if "corpus" in folder.parts:
            continue  # inputs of the fuzzers, found by machine
        readme = root / folder / "README.md"
        text = readme.read_text(encoding="utf-8") if readme.is_file() else ""
        for word in ["include", "start"]:
            if word not in text.lower():
                yield f"{folder}/README.md: must say what the folder does, what it may include and where to start " \
                      f"reading; '{word}' is missing"


MEMBER = re.compile(r"^  (?:(const) )?(\w+) (\w+)((?:\[\w+\])?)(?: = (\w+))?;(?:[ \t]*// (.*))?$")


def field_table(text):
    """An .lcm struct as Markdown: its comment, then its fields with theirs, groups set off by comments of their own."""
    about = re.findall(r"^// ?(.*)$", text, re.MULTILINE)
    rows, group = [*about, "", "| field | type | meaning |", "|---|---|---|"], []
    for line in [line for line in text.splitlines() if line.startswith("  ")]:
        member = MEMBER.match(line)
        if not member:
            group.append(line.strip().removeprefix("// "))
            continue
        if group:
            rows.append(f"| | | *{' '.join(group)}* |")
            group = []
        const, kind, name, array, value, comment = member.groups()
        comment = (comment or "").replace("|", "\\|")
        rows.append(f"| `{name}`{' = ' + value if const else ''} | {'constant' if const else kind + array} | {comment} |")
    return "\n".join(rows)


def with_field_tables(contract, types):
    """`contract` with the text between `<!-- fields of T -->` and `<!-- end -->` replaced by T's field_table."""

    def table(match):
        name = match[1]
        return f"<!-- fields of {name} -->\n{field_table(types[name])}\n<!-- end -->" if name in types else match[0]

    return re.sub(r"<!-- fields of (\w+) -->\n.*?<!-- end -->", table, contract, flags=re.DOTALL)


def lcm_types(root):
    return {f.stem: f.read_text(encoding="utf-8") for f in sorted((root / "lcmtypes").glob("*.lcm"))}


def message_problems(root):
    types = lcm_types(root)
    table = (root / "lcmtypes/README.md").read_text(encoding="utf-8")
    contract = (root / "docs/messages.md").read_text(encoding="utf-8")
    if contract != with_field_tables(contract, types):
        yield "docs/messages.md: field tables are not those of lcmtypes/; cure: tests/repository/docs.py . --write"
    for name, text in types.items():
        if f"`{name}`" not in table:
            yield f"lcmtypes/README.md: no line for {name}"
        if f"<!-- fields of {name} -->" not in contract:
            yield f"docs/messages.md: no field table of {name}"
        for member in filter(None, map(MEMBER.match, text.splitlines())):
            if not member[1] and not member[6]:
                yield f"lcmtypes/{name}.lcm: {member[3]} has no comment (unit, frame, meaning)"
    channels = set(re.findall(r'"(CAIRN_[A-Z]+(?:_[A-Z]+)*)', (root / "common/bus/bus.h").read_text(encoding="utf-8")))
    for channel in sorted(channels):
        if channel not in table:
            yield f"lcmtypes/README.md: no line for channel {channel}"


def link_problems(root):
    pages = [*root.glob("*.md"), *root.glob("docs/*.md"), *(p for t in SOURCE_FOLDERS for p in (root / t).rglob("*.md"))]
    for page in pages:
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if "://" not in link and not (page.parent / link).exists():
                yield f"{page.relative_to(root)}: link to {link}, which does not exist"


def symbol_problems(root):
    """Names like `Reward::Evaluate` and `ReplayBufferTest.SumsNSteps` in docs/algorithms.md must exist."""
    sources = [f.read_text(encoding="utf-8") for top in SOURCE_FOLDERS for f in (root / top).rglob("*")
               if f.suffix in {".h", ".cc"}]
    words = set(re.findall(r"\w+", "\n".join(sources)))
    tests = {f"{m[0]}.{m[1]}" for text in sources
             for m in re.findall(r"^(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", text, re.MULTILINE)}
    page = (root / "docs/algorithms.md").read_text(encoding="utf-8")
    for name in sorted(set(re.findall(r"`([^`\s]+)`", page))):
        if re.fullmatch(r"\w+Test\.\w+", name) and name not in tests:
            yield f"docs/algorithms.md: there is no test {name}"
        if re.fullmatch(r"\w+(::\w+)+", name) and not set(name.split("::")) <= words:
            yield f"docs/algorithms.md: there is no {name}"


FIELD = re.compile(r"^  (?:optional|repeated) [a-z]\w* (\w+) = \d+(.*)$")


def derived_problems(root):
    """An option without a default whose comment says "Derived" must stand in the table of docs/recipes.md."""
    page = (root / "docs/recipes.md").read_text(encoding="utf-8")
    comment, in_comment = "", False
    for line in (root / "common/config/experiment.proto").read_text(encoding="utf-8").splitlines():
        text = line.partition("//")[2]
        if line.strip().startswith("//"):
            comment = f"{comment} {text}" if in_comment else text
        in_comment = line.strip().startswith("//")
        if not line.strip():
            comment = ""
        field = FIELD.match(line)
        if field and "default =" not in field[2] and "Derived" in comment + text and f"`{field[1]}`" not in page \
                and not re.search(rf"`[\w.]+\.{field[1]}`", page):
            yield f"docs/recipes.md: the table of derived values does not have {field[1]}"


def write_field_tables(root):
    page = root / "docs/messages.md"
    page.write_text(with_field_tables(page.read_text(encoding="utf-8"), lcm_types(root)), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[2:] not in ([], ["--write"]):
        sys.exit(__doc__)
    tree = pathlib.Path(sys.argv[1]).resolve()
    if sys.argv[2:]:
        write_field_tables(tree)
    problems = [*readme_problems(tree), *message_problems(tree), *symbol_problems(tree), *link_problems(tree),
                *derived_problems(tree)]
    print("\n".join(problems) or "ok")
    sys.exit(1 if problems else 0)
