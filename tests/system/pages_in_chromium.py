#!/usr/bin/env python3
"""Opens the pages of `cairn plan --html` and `cairn eval --html` in Chromium without screen and network, and compares
what they say they have drawn with what Cairn says there is. Leaves a screenshot of each page. Exits with 77 (skipped)
where there is no Chromium.

    pages_in_chromium.py BIN_DIR SCREENSHOT_DIR
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
SKIP = 77

# Put behind the page's own script: looks at the pixels, takes the roadmap away, lets the trajectories play, and leaves the
# page as it was. Top-level names are the page's. It plays for a moment only: without a GPU a frame takes a while.
PROBE = """
<script>
const probe = { title: document.title };
function look() {
  renderer.render(scene, camera);
  const gl = renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
  const pixels = new Uint8Array(4 * w * h), colors = new Set();
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let painted = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    const color = 65536 * pixels[i] + 256 * pixels[i + 1] + pixels[i + 2];
    colors.add(color);
    if (color !== 0xffffff) ++painted;
  }
  return { painted: painted / (w * h), colors: colors.size, points: renderer.info.render.points };
}
probe.all = look();
const rows = [...document.querySelectorAll('#switches label')];
const roadmapSwitch = rows.find((label) => label.textContent === 'Roadmap').querySelector('input');
roadmapSwitch.click();
probe.withoutRoadmap = look();
roadmapSwitch.click();
probe.end = clock.end;
if (clock.end > 0) {
  element('speed').value = 5;
  element('play').click();
  probe.begin = clock.now.value;
  setTimeout(() => {
    probe.later = clock.now.value;
    if (clock.last !== undefined) element('play').click();
    setNow(clock.end);
    root.dataset.probe = JSON.stringify(probe);
  }, 150);
} else {
  root.dataset.probe = JSON.stringify(probe);
}
</script>
"""


def run(command):
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=120)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {result.returncode}:\n{result.stderr[-2000:]}")
    return result.stdout


def expect(condition, what, *values):
    if not condition:
        sys.exit(f"pages_in_chromium.py: {what}: {', '.join(map(str, values))}")


class Browser:
    def __init__(self, program, work):
        self.command = [program, "--headless", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                        "--hide-scrollbars", "--window-size=1100,760", "--virtual-time-budget=800",
                        "--no-first-run", "--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND",
                        f"--user-data-dir={work / 'profile'}"]
        if os.geteuid() == 0:
            self.command.append("--no-sandbox")  # Chromium refuses to be root with one

    def draw(self, page, image):
        """The root element's data-… after the page's script has run, and a screenshot."""
        dom = run([*self.command, "--dump-dom", f"--screenshot={image}", page.as_uri()])
        expect(image.read_bytes()[:4] == b"\x89PNG", "no picture", image)
        tag = re.search(r"<html[^>]*>", dom)
        expect(tag, "no document", dom[:500])
        unescape = {"&quot;": '"', "&lt;": "<", "&gt;": ">", "&amp;": "&"}
        attributes = dict(re.findall(r'data-(\w+)="([^"]*)"', tag.group()))
        return {k: re.sub("&[a-z]+;", lambda m: unescape[m.group()], v) for k, v in attributes.items()}


def check(browser, page, image, expected):
    """`expected`: what data-drawn must say, without its frame; of the edges not all are drawn."""
    probed = page.with_name("probed.html")
    text = page.read_text(encoding="utf-8")
    probed.write_text(text.replace("</body>", PROBE + "</body>"), encoding="utf-8")
    attributes = browser.draw(probed, image)
    expect("error" not in attributes, f"{page.name}: error", attributes.get("error"))
    expect({"drawn", "probe"} <= set(attributes), f"{page.name}: nothing drawn", attributes)
    drawn, probe = json.loads(attributes["drawn"]), json.loads(attributes["probe"])
    frame = drawn.pop("frame")
    expect(drawn["vertices"] < drawn["edges"] < expected["edges"], f"{page.name}: edges", drawn, expected)
    expected = {**expected, "edges": drawn["edges"]}
    expect(drawn == expected, f"{page.name}: drawn, expected", drawn, expected)
    # What went through the renderer: 12 triangles a box, the vertices as points, the edges among other lines.
    expect(frame["triangles"] >= 12 * drawn["boxes"], f"{page.name}: triangles", frame, drawn)
    expect(frame["points"] == drawn["vertices"], f"{page.name}: points", frame, drawn)
    expect(frame["lines"] >= drawn["edges"] + 12 * drawn["boxes"], f"{page.name}: lines", frame, drawn)
    expect(0.03 < probe["all"]["painted"] < 0.9, f"{page.name}: share of the picture that is painted", probe)
    expect(probe["all"]["colors"] > 1000, f"{page.name}: colours", probe)
    expect(probe["withoutRoadmap"]["points"] == 0, f"{page.name}: the roadmap's switch", probe)
    if drawn["trajectories"]:
        expect(probe["begin"] == 0, f"{page.name}: playing starts over", probe)
        expect(0.1 < probe["later"] <= probe["end"], f"{page.name}: time passes while playing", probe)
    print(f"{page.name}: {page.stat().st_size} bytes, {drawn}, {probe}, {image}")


def plan_page(cairn, experiment, page):
    """Writes the page of an experiment; returns what it must have drawn."""
    out = run([cairn, "plan", experiment, "--html", page])
    number = lambda pattern: int(re.search(pattern, out).group(1))
    return {"boxes": number(r"(\d+) obstacles"), "cylinders": 0,
            "vertices": number(r"vertices +(\d+)") - number(r"(\d+) of them bends"), "edges": number(r"edges +(\d+)"),
            "doors": number(r"doors +(\d+)"), "trajectories": {}}


def eval_page(cairn, run_dir, page, planned):
    run_json = json.loads(run([cairn, "eval", run_dir, "--controller", "pure_pursuit", "--trials", "6", "--json",
                               "--html", page]))
    counts = {"goal": run_json["successes"], "collision": run_json["collisions"], "timeout": run_json["timeouts"],
              "diverged": run_json["diverged"]}
    return {**planned, "doors": 0, "trajectories": {name: count for name, count in counts.items() if count}}


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if not chromium:
        print("skipped: no chromium; deploy/install_dependencies.sh --test installs it")
        return SKIP
    cairn = pathlib.Path(sys.argv[1]) / "cairn"
    screenshots = pathlib.Path(sys.argv[2]).resolve()
    screenshots.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as directory:
        work = pathlib.Path(directory)
        browser = Browser(chromium, work)
        for name in ["quadrotor_maze", "car_maze"]:
            experiment = SOURCE / "deploy/experiments" / f"{name}.textproto"
            page = work / f"{name}_plan.html"
            planned = plan_page(cairn, experiment, page)
            check(browser, page, screenshots / f"{name}_plan.png", planned)
            run_dir = work / name
            run_dir.mkdir()
            shutil.copy(experiment, run_dir / "experiment.textproto")
            page = work / f"{name}_eval.html"
            check(browser, page, screenshots / f"{name}_eval.png", eval_page(cairn, run_dir, page, planned))
    return 0


if __name__ == "__main__":
    sys.exit(main())
