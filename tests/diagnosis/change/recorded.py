"""Two synthetic recordings of one arm, of which the second may have a change; both contain a law that no fit includes."""

from ..made import made

#: Few and short: what is claimed is about the method, and pairs of the blind check tell how good it is.
TRIALS = ((1.11, 0.05, (0.5, 0.15)), (1.11, 0.05, (0.9, 0.5)), (1.11, 0.05, (-0.7, 0.3)), (1.11, 0.05, (0.8, -0.2)))
OTHER = ((1.11, 0.05, (0.6, 0.3)), (1.11, 0.05, (-0.8, 0.2)), (1.11, 0.05, (0.95, 0.4)))
#: In both, and in no model that the tests fit.
LACKS = "stiffening:cubic=0.2"
#: What keeps the tests short.
QUICK = {"effects": ["tip_mass", "actuator_lag"], "max_effects": 0, "links": 8, "jobs": 1}


def recorded(*effects, name="old", trials=TRIALS, **how):
    return made(LACKS, *effects, name=name, trials=trials, draw=name, links=12, **how)
