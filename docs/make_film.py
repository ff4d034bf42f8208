#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes docs/images/film.webp: the scene pile with and without a limit of work, side by side.

    docs/make_film.py POISE OUT.webp

Work is counted, so that the film is the same on every machine. Needs rsvg-convert (librsvg2-bin) and img2webp (webp).
"""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

BODIES = 600
FRAMES = 240
EVERY = 4  # frames of the run a picture: 15 pictures a second, as fast as it happened
BUDGET = 1500
CAMERA = "9.5,-12,8.5:0,0,-0.8:53"
WIDTH, HEIGHT, GAP, TOP, BOTTOM = 456, 300, 8, 40, 74
LEGEND = 41  # rows below a picture that hold its legend, which is cut off: the film has one for both halves
LEVELS = (("#a8adb5", "none"), ("#7d2e99", "root sphere"), ("#4070cc", "level 1"), ("#21a88c", "level 2"), ("#94d14d", "leaves"))
HALVES = (
    ("limited", f"a limit: {BUDGET:,} steps of work a frame", "detail goes where the viewer looks (ring)"),
    ("full", "no limit: every contact down to the leaves", "the work is whatever the heap asks for"),
)


def run(poise, folder, name, limits):
    """Runs the scene, draws its frames, and gives the work of refinement of each frame."""
    capture = folder / f"{name}.capture"
    subprocess.run([poise, "run", "pile", "--bodies", str(BODIES), "--frames", str(FRAMES), "--clock", "work", *limits,
                    "--capture", str(capture), "--quiet"], check=True)
    subprocess.run([poise, "export", str(capture), "--frames-dir", str(folder / name), "--every", str(EVERY),
                    "--camera", CAMERA, "--picture-size", f"{WIDTH}x{HEIGHT + LEGEND}", "--csv", str(folder / f"{name}.csv"),
                    "--quiet"], check=True)
    with open(folder / f"{name}.csv", newline="") as table:
        return {int(row["frame"]): int(row["work"] or 0) for row in csv.DictReader(table)}


def picture(folder, frame, work, most):
    """The two halves of a frame with their words, as SVG."""
    width = 2 * WIDTH + 3 * GAP
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="{width}" '
             f'height="{TOP + HEIGHT + BOTTOM}" font-family="DejaVu Sans, sans-serif">',
             '<rect width="100%" height="100%" fill="#fafafb"/>']
    x = GAP + 4
    for color, name in LEVELS:
        parts.append(f'<rect x="{x}" y="13" width="16" height="16" rx="3" fill="{color}"/>'
                     f'<text x="{x + 22}" y="27" font-size="16" fill="#23282f">{name}</text>')
        x += 22 + 10 * len(name) + 22
    parts.append(f'<text x="{width - GAP - 4}" y="27" font-size="16" fill="#59616b" text-anchor="end">colour: how '
                 f'exactly contacts are solved</text>')
    for i, (name, title, why) in enumerate(HALVES):
        left = GAP + i * (WIDTH + GAP)
        base = TOP + HEIGHT
        bar = (WIDTH - 8) * work[name].get(frame, 0) / most
        parts.append(
            f'<svg x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}"><image width="{WIDTH}" '
            f'height="{HEIGHT + LEGEND}" xlink:href="{name}/frame-{frame:06}.png"/></svg>'
            f'<text x="{left + 4}" y="{base + 23}" font-size="18" font-weight="bold" fill="#23282f">{title}</text>'
            f'<text x="{left + 4}" y="{base + 43}" font-size="15" fill="#59616b">{why}</text>'
            f'<rect x="{left + 4}" y="{base + 51}" width="{WIDTH - 8}" height="16" rx="3" fill="#e3e6ea"/>'
            f'<rect x="{left + 4}" y="{base + 51}" width="{bar:.1f}" height="16" rx="3" fill="#d55e00"/>'
            f'<text x="{left + WIDTH - 8}" y="{base + 64}" font-size="13" text-anchor="end" fill="#23282f">'
            f'work of this frame: {work[name].get(frame, 0):,}</text>')
    return "".join(parts) + "</svg>"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    poise, out = sys.argv[1:]
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        work = {"limited": run(poise, folder, "limited", ["--budget-work", str(BUDGET)]),
                "full": run(poise, folder, "full", [])}
        most = max(work["full"].values())
        frames = sorted(int(file.stem.split("-")[1]) for file in (folder / "full").glob("*.png"))
        for frame in frames:
            (folder / "frame.svg").write_text(picture(folder, frame, work, most))
            subprocess.run(["rsvg-convert", str(folder / "frame.svg"), "-o", str(folder / f"film-{frame:06}.png")],
                           check=True)
        films = [str(folder / f"film-{frame:06}.png") for frame in frames]
        # Each picture as long as it took; the last one long enough to be read.
        words = ["-loop", "0", "-lossy", "-q", "55", "-m", "4", "-d", "67", *films[:-1], "-d", "1500", films[-1]]
        subprocess.run(["img2webp", *words, "-o", out], check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
