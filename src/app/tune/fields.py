# SPDX-License-Identifier: MIT
"""What of a policy can be searched, and which values are tried. Weights are tried in steps, so that what is found can
be read and computed cheaply; ranges are those in which a cue does what its page says (docs/cues.md)."""

# The cues that are measured without a host or a scene that sets them.
CUES = ("frustum", "size", "eccentricity", "closing", "waiting", "occlusion", "gap", "delay", "onset", "crowding",
        "hysteresis", "touch")

# The policy as it ships, as far as it is searched: include/poise/scheduler/policy.h.
SHIPPED = {"frustum": 1, "size": 1, "eccentricity": 1, "closing": 1, "waiting": 1, "occlusion": 0, "gap": 0, "delay": 0,
           "onset": 0, "crowding": 0, "hysteresis": 0, "touch": 1, "learning": 0, "seen_threshold_rad": 0,
           "chance_of_ending": 0.5, "front_growth": 2, "job_overhead_units": 4, "closing_scale_mps": 1, "round_pairs": 512,
           "hidden_visibility": 0.25, "outside_frustum": 0.05, "gap_scale_rad": 0.0029,
           "hysteresis_factor": 2}

# The same as a policy: its weights are those of the scene.
SHIPPED_POLICY = {"kind": "perceptual"}

# The weights of E_seen (docs/reference.md) as far as cues can say them: where a search may begin.
LIKE_THE_MEASURE = {"frustum": 1, "size": 2, "eccentricity": 2, "closing": 0, "waiting": 0, "occlusion": 1}

_STEP = 0.25
CHOICES = {
    **{cue: [_STEP * k for k in range(9)] for cue in CUES},
    "size": [_STEP * k for k in range(13)],
    "eccentricity": [_STEP * k for k in range(13)],
    "learning": [0, 1],
    "seen_threshold_rad": [0, 0.0001, 0.0003, 0.001, 0.003],
    "chance_of_ending": [0.05, 0.1, 0.25, 0.5, 0.75, 1],
    "front_growth": [1, 1.5, 2, 3, 4],
    "job_overhead_units": [1, 4, 16, 64, 256],
    "closing_scale_mps": [0.1, 0.3, 1, 3, 10],
    "round_pairs": [32, 128, 512],
    "hidden_visibility": [0.01, 0.05, 0.25, 0.5],
    "outside_frustum": [0.001, 0.01, 0.05, 0.25],
    "gap_scale_rad": [0.0003, 0.001, 0.0029, 0.01],
    "hysteresis_factor": [2, 4, 16, 64],
}

# Searched unless --search says otherwise. Not round_pairs: smaller rounds cost time that counted work does not show.
SEARCHED = CUES + ("learning", "seen_threshold_rad", "closing_scale_mps", "hysteresis_factor")

# What a run must observe so that its states know what every cue asks for: weights that are too small to decide.
OBSERVED = {"onset": 1e-9, "delay": 1e-9, "learning": 1e-9}
