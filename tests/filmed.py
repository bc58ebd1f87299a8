"""Simulated motions as cameras record them."""

import numpy as np

from hsr_pin.trajectory import Trajectory, Trial


def filmed(motions, noise, seed, levels=(1.11, 0.05), driven=True):
    """Return a trial of each motion, with white noise [m].

    ``levels`` is the declared stiffness and damping of all trials, or of each; ``driven`` whether the torque is recorded.
    """
    generator, trials = np.random.default_rng(seed), []
    motions = list(motions)
    for number, (motion, level) in enumerate(zip(motions, np.broadcast_to(levels, (len(motions), 2)).tolist(), strict=True), 1):
        seen = motion.positions + noise * generator.standard_normal(motion.positions.shape)
        recording = Trajectory(motion.time, motion.markers, seen, torque=motion.torque if driven else None)
        trials.append(Trial(f"trial_{number:02d}", recording, *level))
    return tuple(trials)
