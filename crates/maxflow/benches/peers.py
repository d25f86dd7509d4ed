#!/usr/bin/env python3
"""Times cuts beside PyMaxflow (Boykov and Kolmogorov's own code), OR-tools and SciPy, in one run and in turns.

    cargo bench -p selvedge-maxflow --no-run        # build
    python3 crates/maxflow/benches/peers.py [--rounds N] [--pictures FOLDER] [--graph] [--all] [CASE...]

Needs PyMaxflow and numpy, and for more columns ortools and scipy; says which are missing and goes on without, or ends
well where the first two are. Each round runs the peer, ours, and the peer again; times are milliseconds of one
processor to build and to solve, medians over the rounds. All answers are compared. Peers build from whole arrays.
They are given the graph without auxiliary nodes in both of its forms (a term's two arcs equal, or all in one arc),
and what is told is the faster. With --graph ours is a graph in lists, too. OR-tools and SciPy are asked for small cases
only, unless there is --all.
"""
import argparse
import glob
import os
import subprocess
import sys
import tempfile
import time

try:
    import maxflow
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; pip install PyMaxflow numpy ortools scipy")
    sys.exit(0)
try:
    from ortools.graph.python import max_flow
except ImportError:
    max_flow = None
    print("without OR-tools: pip install ortools")
try:
    import scipy.sparse
    import scipy.sparse.csgraph
except ImportError:
    scipy = None
    print("without SciPy: pip install scipy")

HERE = os.path.dirname(os.path.abspath(__file__))
PIN = 1 << 28


def binary():
    found = glob.glob(os.path.join(HERE, "../../../target/release/deps/solve-*"))
    found = max((f for f in found if "." not in os.path.basename(f)), key=os.path.getmtime, default=None)
    return found or sys.exit("build first: cargo bench -p selvedge-maxflow --no-run")


def run(*words):
    return subprocess.run([binary(), *words], capture_output=True, text=True, check=True).stdout


def load(path):
    """Terminals, arcs and constants of the two forms of an energy."""
    words = np.fromfile(path, "<i4").astype(np.int64)
    axes = int(words[0])
    shape, (pins, unaries, terms) = words[1 : 1 + axes], words[1 + axes : 4 + axes]
    nodes, at = int(shape.prod()), 4 + axes
    pin = words[at : at + 2 * pins].reshape(-1, 2)
    own = words[at + 2 * pins : at + 2 * pins + 2 * unaries].reshape(-1, 2)
    term = words[at + 2 * pins + 2 * unaries :].reshape(-1, 6)
    assert len(term) == terms
    strides = np.array([int(shape[a + 1 :].prod()) for a in range(axes)])
    first, (e00, e01, e10, e11) = term[:, 0], term[:, 2:].T
    second = first + strides[term[:, 1]]
    e00 = np.minimum(e00, e01 + e10 - e11)
    least, most = e11 - e01, e10 - e00
    forms = []
    for u in ((least + most) // 2, most):
        zero, one = np.zeros(nodes, np.int64), np.zeros(nodes, np.int64)
        if unaries:
            zero, one = zero + own[:, 0], one + own[:, 1]
        np.add.at(one, first, u)
        np.add.at(one, second, e11 - e00 - u)
        constant = int(e00.sum() + np.minimum(zero, one).sum())
        source, sink = one - np.minimum(zero, one), zero - np.minimum(zero, one)
        source[pin[pin[:, 1] == 0, 0]] += PIN * 4
        sink[pin[pin[:, 1] == 1, 0]] += PIN * 4
        forms.append((nodes, source, sink, first, second, u - least, most - u, constant))
    return forms


def bk(form):
    """Processor milliseconds of building and solving, the energy, and the size of the sink's side."""
    nodes, source, sink, first, second, forward, back, constant = form
    start = time.thread_time()
    graph = maxflow.GraphInt(nodes, len(first))
    ids = graph.add_grid_nodes(nodes)
    graph.add_grid_tedges(ids, source, sink)
    graph.add_edges(first, second, forward, back)
    built = time.thread_time()
    flow = graph.maxflow()
    done = time.thread_time()
    return (built - start) * 1e3, (done - built) * 1e3, flow + constant


def ends(form):
    """Tails, heads and capacities with the terminals as nodes."""
    nodes, source, sink, first, second, forward, back, _ = form
    v = np.arange(nodes)
    tails = np.concatenate([first, second, np.full(nodes, nodes), v])
    heads = np.concatenate([second, first, v, np.full(nodes, nodes + 1)])
    capacities = np.concatenate([forward, back, source, sink])
    there = capacities > 0
    return tails[there].astype(np.int32), heads[there].astype(np.int32), capacities[there]


def ortools(form):
    nodes, constant = form[0], form[-1]
    tails, heads, capacities = ends(form)
    start = time.thread_time()
    solver = max_flow.SimpleMaxFlow()
    solver.add_arcs_with_capacity(tails, heads, capacities)
    built = time.thread_time()
    solver.solve(nodes, nodes + 1)
    done = time.thread_time()
    return (built - start) * 1e3, (done - built) * 1e3, solver.optimal_flow() + constant


def dinic(form):
    nodes, constant = form[0], form[-1]
    tails, heads, capacities = ends(form)
    start = time.thread_time()
    capacities = np.minimum(capacities, PIN).astype(np.int32)
    graph = scipy.sparse.csr_matrix((capacities, (tails, heads)), shape=(nodes + 2, nodes + 2))
    built = time.thread_time()
    flow = scipy.sparse.csgraph.maximum_flow(graph, nodes, nodes + 1).flow_value
    done = time.thread_time()
    return (built - start) * 1e3, (done - built) * 1e3, int(flow) + constant


def best(peer, forms):
    """The faster of the forms."""
    return min((peer(form) for form in forms), key=lambda times: times[0] + times[1])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--pictures")
    parser.add_argument("--graph", action="store_true")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("cases", nargs="*")
    args = parser.parse_args()
    pictures = ["--pictures", args.pictures] if args.pictures else []
    title = f"{'case':22}{'nodes':>8}  {'BK: build + solve ms':>22}  {'ours':>20}"
    print(f"{title}  {'ratio: solve':>12}{'both':>6}  others")
    logs = []
    for case in args.cases or run("--list").split():
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "instance.bin")
            run(case, "--dump", path, *pictures)
            forms = load(path)
            theirs, mine, sum_of = [], [], 0
            for _ in range(args.rounds):
                one = best(bk, forms)
                words = run(path, *["--graph"] * args.graph).split()
                two = best(bk, forms)
                theirs += [one, two]
                mine.append((float(words[2]), float(words[3])))
                assert {one[2], two[2]} == {int(words[4])}, (one, two, words)
            nodes = forms[0][0]
            others = []
            for name, peer, module, most in (("OR-tools", ortools, max_flow, 300_000), ("SciPy", dinic, scipy, 40_000)):
                if module is None or (nodes > most and not args.all):
                    continue
                build, solve, energy = best(peer, forms)
                assert energy == int(words[4]), (name, energy, words)
                others.append(f"{name} {build + solve:.1f}")
        theirs = np.median(np.array([t[:2] for t in theirs]), 0)
        mine = np.median(np.array(mine), 0)
        both = theirs.sum() / mine.sum()
        logs.append((case, both))
        print(
            f"{case:22}{nodes:8}  {theirs[0]:10.3f} {theirs[1]:11.3f}  {mine[0]:9.3f} {mine[1]:10.3f}"
            f"  {theirs[1] / mine[1]:12.1f}{both:6.1f}  {'  '.join(others)}",
            flush=True,
        )
    for letter in sorted({case[0] for case, _ in logs}):
        ratios = np.log([both for case, both in logs if case[0] == letter])
        print(f"class {letter}: geometric mean {np.exp(ratios.mean()):.2f}, least {np.exp(ratios.min()):.2f}")


main()
