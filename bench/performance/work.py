"""Runs solvers on the problems.

Of every problem: our default until it gives no more, which tells how low the cost can get; both rivals' defaults;
then, for each number of threads, one screening run of every variant, and rounds of the variants
that the screening left, one after the other. Where a run finds a lower cost than was known, those that
no longer go far enough are repeated.
"""

import math
import os
import random
import sys
from dataclasses import dataclass, field

from reproduce.runs import Runs

from . import problems, variants
from .execute import Bounds, Solver, ensure, execute, execute_together, stands, touch_memory
from .logs import SCALING_FROM, TARGETS, Results

STOP = 1.0008  # times the best cost known: a little below the second target
MOST = 500  # iterations of whatever ends by itself
SMALL, MORE_ROUNDS = 300_000, 3  # observations below which solves take less than 0.2 s, and rounds times this
LEAST_LIMIT = 20  # seconds that every variant of Ceres gets, unless another has shown that less will do


@dataclass
class Settings:
    runs: int = 3
    threads: list = field(default_factory=lambda: [1, 2])
    limit: float = 150  # seconds of each run of the screening
    scale: float = 1  # of the generated scenes
    growth: list = field(default_factory=lambda: list(problems.GROWTH))
    growth_iterations: int = 6
    quick: bool = False

    @classmethod
    def quickly(cls):
        return cls(runs=1, limit=5, growth=list(problems.QUICK_GROWTH), quick=True)


class Work(Runs):
    def __init__(self, program, probe, folder, settings, data=None, ceres=None, native=None):
        super().__init__(program, probe, folder)
        self.settings, self.results = settings, Results(folder, settings.threads)
        self.ran = False  # anything, on the problem at hand
        self.makers = problems.Makers(program, folder, data, settings.scale, settings.quick)
        environment = variants.blas_environment()
        self.ceres = {name: Solver("ceres", ceres, options, environment)
                      for name, options in variants.CERES.items()} if ceres else {}
        self.left_alone = {name: Solver("ceres", ceres, f"{options} {variants.CERES_DEFAULTS}", environment)
                           for name, options in variants.CERES.items()} if ceres else {}
        self.ours = {name: Solver("raybundle", program, f"{options} {variants.TIGHT}", {})
                     for name, options in {variants.AUTO: "", **variants.FORCED}.items()}
        if native:
            self.ours[variants.NATIVE] = Solver("raybundle", native, variants.TIGHT, {})
        self.default = Solver("raybundle", program, "", {})

    def measure(self, problem):
        """All runs on one problem."""
        file = self.makers.file(problem)
        if file is None:
            return
        before, self.ran = os.getloadavg()[0], False
        most = max(self.settings.threads)
        self.run(problem, file, "explore", variants.AUTO, self.ours[variants.AUTO], most,
                 Bounds(self.settings.limit, MOST))
        self.run(problem, file, "final", variants.AUTO, self.default, most, Bounds(2 * self.settings.limit, 50))
        for _ in range(3):
            best = self.results.best(problem.name)
            for threads in self.settings.threads:
                self.screen(problem, file, threads)
            self.finish_ceres(problem, file, most)
            if self.results.best(problem.name) >= best:
                break
        small = self.results.counts(problem.name)["observations"] < SMALL and not self.settings.quick
        for threads in self.settings.threads:
            for number in range(1, self.settings.runs * (MORE_ROUNDS if small else 1) + 1):
                self.round(problem, file, threads, number)
        if self.results.counts(problem.name)["observations"] > SCALING_FROM or self.settings.quick:
            for number in range(1, self.settings.runs + 1):
                self.twins(problem, file, number)
        if self.ran:
            self.loads[problem.name] = [before, os.getloadavg()[0]]

    def measure_far(self, problem):
        """Where everybody ends, in the time that they would need many times over from nearby."""
        file = self.makers.file(problem)
        if file is None:
            return
        most, bounds = max(self.settings.threads), Bounds(self.settings.limit / 5, 200)
        for name, solver in {**self.ours, **self.ceres}.items():
            self.run(problem, file, f"screen-{most}", name, solver, most, bounds)

    def run(self, problem, file, kind, name, solver, threads, bounds):
        base = self.results.base(problem.name, kind, name)
        if not stands(solver, base, threads, bounds):
            print(f"reproduce: {problem.name}: {kind} {name}", file=sys.stderr)
            execute(solver, file, base, threads, bounds)
            self.ran = True
        return self.results.read(base)

    def bounds(self, problem, seconds, iterations=MOST):
        best = self.results.best(problem.name)
        return Bounds(seconds, iterations, TARGETS[-1] * best, STOP * best)

    def screen(self, problem, file, threads):
        """Once each, with less time where another variant has shown what is possible."""
        kind = f"screen-{threads}"
        bounds = self.bounds(problem, self.settings.limit, self.needed(problem.name, variants.AUTO))
        run = self.run(problem, file, kind, variants.AUTO, self.ours[variants.AUTO], threads, bounds)
        reached = run.seconds_to(bounds.target)
        for name in variants.FORCED:
            limit = min(self.settings.limit, 2 * reached + 1)
            self.run(problem, file, kind, name, self.ours[name], threads, self.bounds(problem, limit))
        longest = min(self.settings.limit, max(variants.SLOW * reached, LEAST_LIMIT))
        least = math.inf
        for name in variants.ceres_for(self.results.counts(problem.name)["cameras"]) if self.ceres else []:
            bounds = self.bounds(problem, min(longest, variants.LOSES * least + 2))
            run = self.run(problem, file, kind, name, self.ceres[name], threads, bounds)
            least = min(least, run.seconds_to(bounds.target))

    def finish_ceres(self, problem, file, threads):
        """Where Ceres ends when nothing but its own defaults stops it."""
        chosen = self.results.chosen_ceres(problem.name, threads)
        if chosen and self.ceres:
            self.run(problem, file, "final", "ceres", self.left_alone[chosen[0]], threads,
                     Bounds(2 * self.settings.limit, 50))

    def round(self, problem, file, threads, number):
        """Every variant once, each round in an order of its own: what a run leaves behind of memory matters
        to the next. A round is whole or made again."""
        name, kind = problem.name, f"timed-{threads}-{number}"
        wanted = {}
        ours = [variants.AUTO, *self.results.chosen_forced(name, threads),
                *([variants.NATIVE] if variants.NATIVE in self.ours else [])]
        for each in ours:
            wanted[each] = self.ours[each], self.bounds(problem, self.settings.limit, self.needed(name, each))
        for each in self.results.chosen_ceres(name, threads) if self.ceres else []:
            wanted[each] = self.ceres[each], self.bounds(problem, self.settings.limit)
        if all(stands(solver, self.results.base(name, kind, each), threads, bounds)
               for each, (solver, bounds) in wanted.items()):
            return
        order = [*wanted]
        random.Random(number).shuffle(order)
        print(f"reproduce: {name}: {threads} threads, round {number}: {', '.join(order)}", file=sys.stderr)
        self.ran = True
        for each in order:
            solver, bounds = wanted[each]
            touch_memory(self.expected_peak(name, threads, each))
            execute(solver, file, self.results.base(name, kind, each), threads, bounds)

    def expected_peak(self, problem, threads, name):
        """Bytes, from the screening."""
        shown = variants.AUTO if name == variants.NATIVE else name
        run = self.results.run(problem, f"screen-{threads}", shown)
        return run.peak if run else 0

    def twins(self, problem, file, number):
        """Our default twice at once, one thread each: what two cores gain for just this work, when nobody
        waits for anybody."""
        bounds = self.bounds(problem, self.settings.limit, self.needed(problem.name, variants.AUTO))
        bases = [self.results.base(problem.name, f"twins-{number}", f"{variants.AUTO}-{twin}") for twin in (1, 2)]
        if not all(stands(self.ours[variants.AUTO], base, 1, bounds) for base in bases):
            print(f"reproduce: {problem.name}: two at once, round {number}", file=sys.stderr)
            touch_memory(2 * self.expected_peak(problem.name, 1, variants.AUTO))
            execute_together(self.ours[variants.AUTO], file, bases, 1, bounds)
            self.ran = True

    def needed(self, problem, name):
        """Iterations of ours until the stop cost: runs are the same bit by bit, whatever the threads, so
        that a bound on them ends a run there."""
        shown = variants.AUTO if name == variants.NATIVE else name
        kinds = [f"screen-{threads}" for threads in self.settings.threads]
        kinds += ["explore"] if shown == variants.AUTO else []
        runs = [self.results.run(problem, kind, shown) for kind in kinds]
        counts = [run.iterations_to(STOP * self.results.best(problem)) for run in runs if run]
        counts = [count for count in counts if math.isfinite(count)]
        return max(counts, default=MOST) + (2 if name == variants.NATIVE else 0)

    def grow(self):
        """Some iterations on longer and longer streets, round by round."""
        streets = [problems.street(count) for count in self.settings.growth]
        solver = self.default
        bounds = Bounds(self.settings.limit, self.settings.growth_iterations)
        for number in range(1, self.settings.runs + 1):
            for street in streets:
                file = self.makers.file(street)
                if ensure(solver, file, self.results.base(street.name, f"growth-{number}", variants.AUTO),
                          max(self.settings.threads), bounds):
                    print(f"reproduce: {street.name}, round {number}", file=sys.stderr)

    def largest(self):
        file = self.makers.file(problems.LARGEST)
        self.run(problems.LARGEST, file, "final", variants.AUTO, self.default, max(self.settings.threads),
                 Bounds(4 * self.settings.limit, 50))
