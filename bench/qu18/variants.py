"""The methods of the thesis as options of `raybundle solve`, every choice spelled out."""

ROOT_OPTIONS = {
    "function-tolerance": "1e-16",
    "gradient-tolerance": "0",
    "parameter-tolerance": "0",
    "max-consecutive-failures": "40",
    "lens": "free",
}
SIDES = {"H": "none", "C": "points", "B": "cameras"}
MATRICES = {"I": "identity", "inc": "inc", "diag": "diag-h"}
STARTING_DAMPING = {"identity": "1", "inc": "1", "diag-h": "1e-4"}


# What `raybundle increments` finds on Ladybug 49 and on the balls, and our reading of (3.38).
LADYBUG_INC = {"rotation": "1e-9", "translation": "1e-9", "focal": "1e-6", "k1": "1e-9", "k2": "1e-9",
               "point": "1e-9"}
BALL_INC = {"rotation": "1e-8", "translation": "1e-6", "focal": "1e-6", "k1": "1e-8", "k2": "1e-8",
            "point": "1e-5"}
THESIS_INC = {"rotation": "1e-8", "translation": "1e-5", "focal": "1e-3", "k1": "1e-7", "k2": "1e-7",
              "point": "1e-8"}


def increments(vector):
    return {"inc_" + kind: step for kind, step in vector.items()}


def options(method, **choices):
    """The option string; a choice `max_iterations=3` becomes `--max-iterations 3`."""
    if "inc" in (choices.get("scaling"), choices.get("damping_matrix")):
        choices = {**increments(LADYBUG_INC), **choices}
    words = ["--method", method]
    for key, value in choices.items():
        words += ["--" + key.replace("_", "-"), str(value)]
    return " ".join(words)


def damping(matrix):
    name = MATRICES[matrix]
    return {"damping_matrix": name, "initial_damping": STARTING_DAMPING[name]}


def inner(limit=1000, forcing=0.1, preconditioner="identity"):
    return {"preconditioner": preconditioner, "forcing_rule": "thesis", "forcing": forcing,
            "max_inner_iterations": limit}


def lm(side="C", matrix="I", **more):
    linear = "dense-cholesky" if side == "C" else "sparse-cholesky"
    choices = {"pose_update": "global", "elimination": SIDES[side], "linear": linear,
               "loss": "none", **damping(matrix), **more}
    return options("lm-cholesky", **choices)


def tnm(side="C", matrix="diag", **more):
    """Alg. 7 scales the system by the damping matrix; its diag(H) is taken as a square root, as in (2.52)."""
    return options("tnm", **{"pose_update": "global", "elimination": SIDES[side],
                             "scaling": MATRICES[matrix], "loss": "none", **damping(matrix),
                             **inner(), **more})


def inm(side="C", scaling="inc", **more):
    return options("inm", **{"pose_update": "global", "elimination": SIDES[side],
                             "scaling": MATRICES[scaling], "loss": "none", **inner(), **more})


def dinm(scaling="inc", matrix="I", method="dinm", **more):
    side = {} if method == "adinm" else {"elimination": "points"}
    return options(method, **{"pose_update": "global", **side, "scaling": MATRICES[scaling],
                              "loss": "none", **damping(matrix), **inner(), **more})


def bal(**more):
    return tnm("C", "diag", preconditioner="b", **more)


def irls(limit, **more):
    """The loss is of each component, as (4.20) has it; its scale is not printed: 1 pixel."""
    return dinm(method="irls", max_inner_iterations=limit, pose_update="local", loss="huber",
                loss_scope="component", loss_scale=1, **more)


def six(limit, prefix="", inc=None):
    """The implementations that chapter 5 compares; `inc`: the increments, those of Ladybug if None."""
    more = {"max_inner_iterations": limit, **increments(inc or {})}
    return {
        prefix + "LMA-CD": lm(),
        prefix + "BAL": bal(max_inner_iterations=limit),
        prefix + "DINM": dinm(**more),
        prefix + "ADINM": dinm(method="adinm", **more),
        prefix + "local-DINM": dinm(pose_update="local", **more),
        prefix + "IRLS": irls(limit, **increments(inc or {})),
    }


def ball(limit):
    """Six with the increments of balls, and DINM with those of others."""
    return {**six(limit, inc=BALL_INC), "DINM-3.38": six(limit, inc=THESIS_INC)["DINM"],
            "DINM-ladybug": six(limit)["DINM"]}


def ladybug():
    """All runs of chapters 3, 4 and 5 on Ladybug; names are unique."""
    # Many trials of mu I are rejected: more of them, for the same number of accepted steps.
    runs = {"CD-C": lm("C", max_iterations=130), "CD-H": lm("H", max_iterations=130), "CD-B": lm("B"),
            "CD-C-diag": lm("C", "diag"), "BAL": bal()}
    for start in ("1e-4", "1e4"):
        runs["CD-C-" + start] = lm("C", initial_damping=start, max_iterations=130)
    for side in SIDES:
        for matrix in MATRICES:
            runs[f"INM-{side}-{matrix}"] = inm(side, matrix)
            runs[f"TNM-{side}-{matrix}"] = tnm(side, matrix)
    # With its first step free, this one comes to where no radius makes the points' part of a step short
    # enough: the region bounds the cameras' part alone.
    runs["INM-C-inc-free"] = runs["INM-C-inc"]
    runs["INM-C-inc"] = inm("C", "inc", initial_radius=0.01)
    for pair in (("inc", "I"), ("inc", "diag"), ("diag", "I"), ("diag", "inc")):
        runs["DINM-" + "-".join(pair)] = dinm(*pair)
    for name in ("block-diag-s", "b", "diag-s", "diag-b"):
        runs["pre-" + name] = dinm(preconditioner=name)
    for limit in (100, 300, 500, 700, 2000):
        runs[f"inner-{limit}"] = dinm(max_inner_iterations=limit)
    for forcing in ("0.5", "0.2", "0.1", "0.05", "0.01"):
        runs[f"forcing-{forcing}"] = dinm(forcing=forcing, max_inner_iterations=100000)
    for method in ("dinm", "adinm"):
        more = {"method": method, "max_inner_iterations": 3000}
        name = method.upper() + "3000-"
        runs[name + "inc-I"] = dinm(**more)
        runs[name + "inc-diag"] = dinm("inc", "diag", **more)
        runs[name + "inc-I-diag"] = dinm(preconditioner="diag-b", **more)
    runs["local"] = dinm(pose_update="local")
    return runs


def evaluation():
    """Figures 5.6 and 5.7: longer, with more inner iterations."""
    return six(3000, "long-")
