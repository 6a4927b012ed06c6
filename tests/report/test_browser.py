"""The page of results in a browser without network: what it draws, loads and refuses."""

import base64
import json
import time
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import pytest

from bearingsim.report.page import make_page
from bearingsim.report.render import render_html
from tests.plots.test_plot_designs import HEAD, OVER
from tests.report.chromium import PROGRAM, Tab, browser
from tests.scenes import figure_results

pytestmark = pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed")

AXE = Path(__file__).parents[2] / "tools/report-assets/node_modules/axe-core/axe.min.js"
SCRIPT = "</script><img src=x onerror=alert(1)>"
BIDI = "\u202egnp"
SWEPT = f"""{HEAD}sweep:
  defect.length: [3 mm, 6 mm, 9 mm]
  zip: {{load: [150 N, 300 N], model: [static, ring]}}
  clearance: [0 um, 5 um, 10 um]
  defect.angle: [0 deg, 10 deg]
  where: [load < 200 N or clearance < 7 um]
figures:
  - {{y: [velocity@BPFO, velocity@BPFO-healthy], x: defect.length, by: defect.angle, panels: clearance}}
  - {{y: velocity.rms, x: model, by: defect.angle, title: '{SCRIPT} "quoted" {BIDI}'}}
  - {{y: velocity@BPFO, x: defect.length, by: defect.angle, where: {{clearance: 10 um}}}}
  - {{kind: pit, where: {{clearance: 0 um, defect.length: 3 mm, defect.angle: 0 deg, model: ring}}}}
"""
DESIGN = f"{HEAD}sweep:\n  saltelli: {{n: 8, seed: 1, {OVER}}}\n"


def record(case):
    """A made-up result; that of the shortest defect is chaotic, without a known standard error."""
    made = ORIGINAL(case)
    chaotic = float(bool(case.defects) and case.defects[0].length < 4e-3)
    scatter = {} if chaotic else {"velocity@BPFO-scatter": made.features["velocity@BPFO-scatter"]}
    made.features = {**made.features, "chaotic": chaotic, "velocity@BPFO-scatter": float("nan"), **scatter}
    return made


ORIGINAL = figure_results.record


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Pages by name, each beside the results that it shows."""
    written = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure_results, "record", record)
        for name, text, lost in (("swept", SWEPT, {4: "failed", 5: "missing"}), ("design", DESIGN, {})):
            folder = tmp_path_factory.mktemp(name)
            opened = figure_results.results.__wrapped__(folder, None)(text, lost)  # type: ignore[attr-defined]
            written[name] = opened.path / "report.html"
            written[name].write_text(render_html(make_page(opened)), encoding="utf-8")
    return written


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tab]:
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


def test_page_loads_no_external_resource_and_logs_no_error(tab, pages):
    for path in pages.values():
        for width, dark in ((1280, False), (360, True)):
            tab.open(path, width, dark)
            outside = [address for address in tab.requests if not address.startswith("data:")]
            assert (tab.messages, outside) == ([], [path.as_uri()[:100]])
            assert tab.run("document.documentElement.scrollWidth") <= width


EVERY_SETTING = """
[...document.querySelectorAll('.chart')].flatMap((section) =>
  [...section.querySelectorAll('.controls label')].flatMap((label) => {
    const input = label.querySelector('input, select');
    const count = input.options ? input.options.length : Number(input.max) + 1;
    return Array.from({length: count}, (_, i) => {
      input.value = i;
      input.dispatchEvent(new Event('input', {bubbles: true}));
      const plots = [...section.querySelectorAll('.plot')];
      return [label.querySelector('output').textContent, Number(input.value),
              plots.map((plot) => plot.querySelectorAll('svg path[transform]').length)];
    });
  }))
"""


def test_every_setting_of_every_control_draws_points(tab, pages):
    settings = {}
    for name, path in pages.items():
        tab.open(path)
        settings[name] = tab.run(EVERY_SETTING)
        assert all(count > 0 for _, _, counts in settings[name] for count in counts)
        assert tab.messages == []
    texts = [text for text, _, _ in settings["swept"]]
    assert texts[:5] == ["0 µm", "5 µm", "10 µm", "150 N, static", "300 N, ring"]
    assert [text for text, _, _ in settings["design"]][:3] == ["load", "defect length", "defect angle"]


HOVERED = """
(() => {
  const plot = document.querySelector('.plot');
  plot.scrollIntoView();
  const boxes = [...plot.querySelectorAll('svg path[transform]')].map((p) => p.getBoundingClientRect());
  const centres = boxes.map((b) => b.x + b.width / 2);
  return [Math.min(...centres) + 2, Math.max(...centres) - 2].map((x) => [x, boxes[0].y + 5]);
})()
"""
TOOLTIP = "[...document.querySelector('.plot').querySelectorAll('svg text')].map((t) => t.textContent)"


def hover(tab: Tab, x: float, y: float, begin: str) -> list[str]:
    """Move the mouse to a point of a plot; return the lines of the tooltip that begins with a text."""
    tab.call("Input.dispatchMouseEvent", type="mouseMoved", x=x - 1, y=y)
    tab.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    end = time.monotonic() + 10.0
    while time.monotonic() < end:
        texts = tab.run(TOOLTIP)
        if begin in texts:
            return list(texts[texts.index(begin) :])
        time.sleep(0.05)
    raise AssertionError(f"no tooltip: {texts}")


def test_values_under_the_mouse_are_those_of_the_results(tab, pages):
    tab.open(pages["swept"])
    table = pd.read_csv(pages["swept"].parent / "results.csv", comment="#")
    for (x, y), length in zip(tab.run(HOVERED), (3, 9), strict=True):
        _, *lines = hover(tab, x, y, f"Defect length (mm): {length}")
        assert len(lines) == 2
        for line, angle in zip(lines, (0.0, 10.0), strict=True):
            rows = table[
                (table["clearance"] == 0.0)
                & (table["model"] == "static")
                & ((table["defect.length"] - 1e-3 * length).abs() < 1e-6)
                & ((table["defect.angle"].abs() > 0.01) == (angle > 0.0))
            ]
            [value] = 1e6 * rows["velocity@BPFO"]
            assert line.startswith(f"angle {angle:g}°: {value:.4g} µm/s")
            assert line.endswith(", chaotic") == (length == 3)


CONTRASTS = """
(() => {
  const rgb = (text) => text.match(/[\\d.]+/g).map(Number);
  const light = (c) => c.slice(0, 3).map((v) => v / 255)
    .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const paper = (e) => {
    for (; e; e = e.parentElement) {
      const c = rgb(getComputedStyle(e).backgroundColor);
      if (c.length === 3 || c[3] > 0) return c;
    }
  };
  const own = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
  return [...document.querySelectorAll('body *')].filter((e) => own(e) && e.checkVisibility()
    && !['SCRIPT', 'NOSCRIPT', 'STYLE', 'OPTION'].includes(e.tagName)).map((e) => {
    const style = getComputedStyle(e);
    const ink = light(rgb(e.closest('svg') ? style.fill : style.color));
    const back = light(paper(e));
    return [(Math.max(ink, back) + 0.05) / (Math.min(ink, back) + 0.05), parseFloat(style.fontSize),
            e.textContent.slice(0, 40), Boolean(e.closest('svg'))];
  });
})()
"""


@pytest.mark.parametrize("dark", [False, True])
def test_all_texts_are_legible_on_a_phone(tab, pages, dark):
    for path in pages.values():
        tab.open(path, 360, dark)
        texts = tab.run(CONTRASTS)
        assert sum(is_svg for *_, is_svg in texts) > 20
        assert [entry for entry in texts if entry[0] < 4.5 or entry[1] < 11.0] == []


def test_texts_of_a_study_are_shown_as_texts(tab, pages):
    tab.open(pages["swept"])
    heading = f'{SCRIPT} "quoted" \\u202egnp'
    assert heading in tab.run("[...document.querySelectorAll('h2')].map((h) => h.textContent)")
    assert tab.run("document.querySelectorAll('img[src=x]').length") == 0
    assert tab.run("document.body.innerText.includes('\\u202e')") is False
    assert tab.messages == []


INJECTED = """
new Promise((done) => {
  const refused = [];
  document.addEventListener('securitypolicyviolation', (e) => {
    refused.push(e.effectiveDirective);
    if (refused.length === 3) finish();
  });
  const finish = () => done([refused.sort(), window.injected === undefined]);
  setTimeout(finish, 5000);
  const script = document.createElement('script');
  script.textContent = 'window.injected = 1';
  const image = document.createElement('img');
  image.src = 'https://example.org/x.png';
  const handler = document.createElement('div');
  handler.innerHTML = '<img src="data:," onerror="window.injected = 2">';
  document.body.append(script, image, handler);
})
"""


def test_injected_scripts_and_outside_images_are_refused(tab, pages):
    tab.open(pages["swept"])
    refused, untouched = tab.run(INJECTED)
    assert refused == ["img-src", "script-src-attr", "script-src-elem"]
    assert untouched


def test_pictures_replace_charts_without_scripts(tab, pages):
    tab.open(pages["swept"], script=False)
    image = tab.call("Page.captureScreenshot", format="png")
    assert len(base64.b64decode(image["data"])) > 10_000
    text = pages["swept"].read_text()
    fallback = text[text.index("<noscript>") : text.index("</noscript>")]
    assert fallback.count('src="data:image/svg+xml') == 3
    assert text.count('src="data:image/svg+xml') == 4  # the defect is a picture for everyone


def test_print_shows_settings_as_text_and_fits_the_page(tab, pages):
    tab.open(pages["swept"], dark=True)
    tab.run("dispatchEvent(new Event('beforeprint'))")
    assert tab.run(
        "[...document.querySelectorAll('.plot svg')].every((s) => s.getBoundingClientRect().width <= 680)"
    )
    assert tab.run("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    tab.call("Emulation.setEmulatedMedia", media="print")
    assert tab.run("[...document.querySelectorAll('.controls output')].every((o) => o.checkVisibility())")
    assert not tab.run("[...document.querySelectorAll('.controls select')].some((o) => o.checkVisibility())")
    tab.call("Emulation.setEmulatedMedia", media="")
    assert len(base64.b64decode(tab.call("Page.printToPDF", preferCSSPageSize=True)["data"])) > 50_000


def test_table_sorts_filters_and_legend_hides(tab, pages):
    tab.open(pages["swept"])
    first = "document.querySelector('#table tbody tr:not([hidden])').textContent"
    tab.run("document.querySelectorAll('#table th')[5].click()")
    ascending = tab.run(first)
    tab.run("document.querySelectorAll('#table th')[5].click()")
    assert tab.run(first) != ascending
    assert tab.run("document.querySelectorAll('#table th')[5].ariaSort") == "descending"
    tab.run("(() => { const f = document.getElementById('filter'); f.value = 'failed';"
            "f.dispatchEvent(new Event('input')); })()")  # fmt: skip
    assert tab.run("document.querySelectorAll('#table tbody tr:not([hidden])').length") == 1
    symbols = "document.querySelector('.plot').querySelectorAll('svg path[transform]').length"
    before = tab.run(symbols)
    tab.run("document.querySelector('.legend input').click()")
    assert tab.run(symbols) < before


def test_ids_are_sorted_as_text(tab, pages):
    """An id may look like a number, `1e5000`, or begin with one."""
    tab.open(pages["swept"])
    head, cells = (
        "document.querySelector('#table th')",
        "[...document.querySelectorAll('#table tbody tr td:first-child')]",
    )
    assert tab.run(f"{head}.textContent.trim()") == "job"
    count = tab.run(f"{cells}.length")
    ids = [f"{('b07c', '9e1d', '20f', '1e5', 'a1e5')[k % 5]}{k:03d}" for k in range(count)]
    tab.run(f"{cells}.forEach((cell, k) => {{ cell.textContent = {json.dumps(ids)}[k]; }})")
    tab.run(f"{head}.click()")
    assert tab.run(f"{cells}.map((cell) => cell.textContent)") == sorted(ids)


@pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed: `make report-check` installs it")
@pytest.mark.parametrize("dark", [False, True])
def test_axe_reports_no_violation(tab, pages, dark):
    for path in pages.values():
        tab.open(path, 1280, dark)
        tab.run(AXE.read_text())
        violations = tab.run(
            "axe.run().then((r) => r.violations.map((v) => [v.id, v.nodes.length, v.nodes[0].html]))"
        )
        assert violations == [], json.dumps(violations, indent=1)[:3000]
