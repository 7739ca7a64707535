"""A picture of a page: screenshot.py PAGE PNG [--dark | --print] [--size WxH | --whole] [--script JAVASCRIPT].

docs/figures/report.png is examples/scenes/paper-both-ends.toml, --size 1000x1270 --script "viscobar.player.go(5.5)".
"""

import argparse

import chromium

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("page")
parser.add_argument("png")
parser.add_argument("--dark", action="store_true")
parser.add_argument("--print", action="store_true")
parser.add_argument("--size", default="1100x900")
parser.add_argument("--whole", action="store_true")
parser.add_argument("--script")
options = parser.parse_args()

browser = chromium.Chromium(*map(int, options.size.split("x")))
try:
    browser.open(options.page)
    browser.media("print" if options.print else "screen", "dark" if options.dark else "light")
    if options.script:
        browser.evaluate(options.script)
        browser.settle()
    browser.screenshot(options.png, options.whole)
    for message in browser.messages:
        print(message)
finally:
    browser.close()
