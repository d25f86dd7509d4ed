#!/usr/bin/env python3
"""Times the searcher beside OpenCV, SciPy and FFTW, in one run and in turns.

    cargo bench -p selvedge-fft-ssd --no-run        # build
    python3 crates/fft-ssd/benches/peers.py [--rounds N] [CASE...]

Needs opencv-python-headless, pyfftw, scipy and numpy; says so and ends well where they are missing. Each round runs the
peer, ours, and the peer again; times are the least of a round's warm calls and the median over rounds, in milliseconds of
the clock on one thread.
"""
import argparse
import glob
import os
import subprocess
import sys
import time

try:
    import cv2
    import numpy as np
    import pyfftw
    import scipy.fft
except ImportError as missing:
    print(f"skipped: {missing}; pip install opencv-python-headless pyfftw scipy numpy")
    sys.exit(0)

RNG = np.random.default_rng(1)
HERE = os.path.dirname(os.path.abspath(__file__))


def ours(case, *options):
    """Least milliseconds of a case."""
    found = glob.glob(os.path.join(HERE, "../../../target/release/deps/search-*"))
    binary = max((f for f in found if "." not in os.path.basename(f)), key=os.path.getmtime, default=None)
    if binary is None:
        sys.exit("build first: cargo bench -p selvedge-fft-ssd --no-run")
    line = subprocess.run([binary, case, *options], capture_output=True, text=True, check=True).stdout
    return float(line.split()[2])


def least(call, repeat):
    call()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        call()
        times.append((time.perf_counter() - start) * 1e3)
    return min(times)


def mask_of(name):
    """Side and mask of a template, as the bench makes them."""
    y, x = np.mgrid[: int(name.strip("Ldisc").split("-")[0]), : int(name.strip("Ldisc").split("-")[0])]
    n = y.shape[0]
    if name.startswith("L"):
        overlap = int(name.split("-")[1])
        return (y < overlap) | (x < overlap)
    if name.startswith("disc"):
        return n * n < 4 * ((2 * y + 1 - n) ** 2 + (2 * x + 1 - n) ** 2)
    return None


def opencv(case):
    side, name = case.split("/")
    mask = mask_of(name)
    n = int(name.strip("Ldisc").split("-")[0])
    image = RNG.integers(0, 256, (int(side), int(side), 3), np.uint8)
    template = RNG.integers(0, 256, (n, n, 3), np.uint8)
    cv2.setNumThreads(1)
    if mask is None:
        return lambda: cv2.matchTemplate(image, template, cv2.TM_SQDIFF)
    mask3 = np.repeat(mask.astype(np.uint8)[:, :, None], 3, 2)
    return lambda: cv2.matchTemplate(image, template, cv2.TM_SQDIFF, mask=mask3)


def clip_spectra():
    volume = RNG.random((3, 30, 100, 150))
    part = np.zeros_like(volume)
    part[:, :15, :50, :75] = RNG.random((3, 15, 50, 75))
    return volume, part


def fftw(_):
    """The paper's search: transform the sub-volume, multiply, transform back; the volume's spectra are kept. Float, as FFTW users do."""
    volume, part = clip_spectra()
    shape = volume.shape[1:]
    forward = pyfftw.builders.rfftn(part[0].astype(np.float32), threads=1, planner_effort="FFTW_MEASURE")
    kept = [forward(v.astype(np.float32)).copy() for v in volume]
    parts = [p.astype(np.float32) for p in part]
    total = pyfftw.empty_aligned(kept[0].shape, np.complex64)
    back = pyfftw.builders.irfftn(total, s=shape, threads=1, planner_effort="FFTW_MEASURE")

    def search():
        total[:] = 0
        for p, k in zip(parts, kept):
            np.add(total, np.conj(forward(p)) * k, out=total)
        return back(total)

    return search


def fftw_double(_):
    """The same in double precision, which exact integers need."""
    volume, part = clip_spectra()
    shape = volume.shape[1:]
    forward = pyfftw.builders.rfftn(part[0], threads=1, planner_effort="FFTW_MEASURE")
    kept = [forward(v).copy() for v in volume]
    total = pyfftw.empty_aligned(kept[0].shape, np.complex128)
    back = pyfftw.builders.irfftn(total, s=shape, threads=1, planner_effort="FFTW_MEASURE")

    def search():
        total[:] = 0
        for p, k in zip(part, kept):
            np.add(total, np.conj(forward(p)) * k, out=total)
        return back(total)

    return search


def scipy_clip(_):
    volume, part = clip_spectra()
    kept = scipy.fft.rfftn(volume, axes=(1, 2, 3))
    return lambda: scipy.fft.irfftn((np.conj(scipy.fft.rfftn(part, axes=(1, 2, 3))) * kept).sum(0), s=volume.shape[1:])


ROWS = [
    ("1024/64", opencv, "OpenCV"),
    ("1024/disc64", opencv, "OpenCV + mask"),
    ("192/L36-6", opencv, "OpenCV + mask"),
    ("clip", fftw, "FFTW float"),
    ("clip", fftw_double, "FFTW double"),
    ("clip", scipy_clip, "SciPy double"),
]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("cases", nargs="*")
    args = parser.parse_args()
    print(f"{'case':14}{'peer':16}{'peer ms':>10}{'ours ms':>10}{'ratio':>8}  others")
    for case, peer, name in ROWS:
        if args.cases and case not in args.cases:
            continue
        call, theirs, mine = peer(case), [], []
        levels = {"avx2": [], "scalar": []} if case == "192/L36-6" else {}
        for _ in range(args.rounds):
            before = least(call, 5)
            mine.append(ours(case, "--repeat", "15"))
            for level, times in levels.items():
                times.append(ours(case, "--repeat", "15", "--simd", level))
            theirs.append((before + least(call, 5)) / 2)
        peer_ms, our_ms = float(np.median(theirs)), float(np.median(mine))
        others = "  ".join(f"{k} {peer_ms / np.median(v):.1f}x" for k, v in levels.items())
        print(f"{case:14}{name:16}{peer_ms:10.3f}{our_ms:10.3f}{peer_ms / our_ms:7.1f}x  {others}", flush=True)


main()
