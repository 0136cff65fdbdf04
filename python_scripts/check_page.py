#!/usr/bin/env python3
"""Opens pages that `bia study` and `bia survey` wrote in headless Chromium, from the disk and without a network,
and says what is wrong with them: messages of the console, requests for anything else, figures or tables that
are missing or have no size, text beyond the right edge on a narrow screen.

    check_page.py PAGE.html... [--figures N] [--browser PROGRAM] [--pictures FOLDER]

Needs playwright (PyPI) and a Chromium: its own (`playwright install chromium`), or one of the system
(`apt-get install chromium`), which is found by itself. --figures is the least number of figures of each page;
--pictures keeps a picture of each in light and in dark mode. Exits 1 if something is wrong.
"""

import argparse
import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# What the page itself knows of its content.
MEASURE = """() => {
    const box = (element) => { const r = element.getBoundingClientRect(); return [r.width, r.height]; };
    const figures = [...document.querySelectorAll('svg.chart')];
    return {
        figures: figures.map(box),
        marks: figures.map((figure) => figure.querySelectorAll('path.mark > title').length),
        tables: [...document.querySelectorAll('table')].map((table) => table.rows.length),
        title: document.title,
        overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
        ground: getComputedStyle(document.body).backgroundColor,
        ink: getComputedStyle(document.body).color,
    };
}"""


def brightness(colour):
    """0 for black, 1 for white, of a computed colour such as rgb(1, 2, 3)."""
    red, green, blue = (int(part) for part in colour[colour.index("(") + 1 : -1].split(",")[:3])
    return (0.2126 * red + 0.7152 * green + 0.0722 * blue) / 255


def check(browser, path, figures, pictures):
    """The faults of a page, each a line."""
    faults = []
    for scheme in ("light", "dark"):
        page = browser.new_page(viewport={"width": 1200, "height": 900}, color_scheme=scheme)
        page.on("console", lambda message: faults.append(f"{scheme}: the console says {message.text!r}"))
        page.on("pageerror", lambda error: faults.append(f"{scheme}: {error}"))
        page.on("request", lambda request: request.url.startswith(("file:", "data:"))
                or faults.append(f"{scheme}: asks for {request.url}"))
        page.goto(path.resolve().as_uri())
        found = page.evaluate(MEASURE)
        if not found["title"]:
            faults.append("has no title")
        if len(found["figures"]) < figures:
            faults.append(f"has {len(found['figures'])} figures, not {figures}")
        if any(width < 300 or height < 150 for width, height in found["figures"]):
            faults.append(f"{scheme}: a figure is hardly there: {found['figures']}")
        if any(count == 0 for count in found["marks"]):
            faults.append("a figure has no marks that tell what they are")
        if not any(rows > 1 for rows in found["tables"]):
            faults.append("has no table with rows")
        is_dark = brightness(found["ground"]) < brightness(found["ink"])
        if is_dark != (scheme == "dark") or abs(brightness(found["ground"]) - brightness(found["ink"])) < 0.5:
            faults.append(f"{scheme}: {found['ink']} on {found['ground']} can hardly be read")
        if pictures:
            page.screenshot(path=str(pictures / f"{path.stem}_{scheme}.png"), full_page=True)
        page.set_viewport_size({"width": 390, "height": 800})
        overflow = page.evaluate(MEASURE)["overflow"]
        if overflow > 0:
            faults.append(f"is {overflow} pixels too wide for a small screen")
        page.close()
    return sorted(set(faults))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--figures", type=int, default=0)
    parser.add_argument("--browser", help="program of a Chromium")
    parser.add_argument("--pictures", type=Path)
    arguments = parser.parse_args()
    if arguments.pictures:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
    program = arguments.browser or next(filter(None, map(shutil.which, BROWSERS)), None)
    wrong = 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        for path in arguments.pages:
            faults = check(browser, path, arguments.figures, arguments.pictures)
            wrong += bool(faults)
            print(f"{path}: {'; '.join(faults) or 'nothing wrong'}")
        browser.close()
    print(f"{len(arguments.pages)} pages, {wrong} with faults")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
