# SPDX-License-Identifier: Apache-2.0
"""Plots what a campaign came to: touch-downs on the pad, and their error over the wind."""

import sys

import kestrel.campaign
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import pandas as pd


def plot(runs, file):
    figure, (pad, wind) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    for status, some in runs.groupby("status"):
        look = dict(s=12, color="tab:blue" if status == "passed" else "tab:red", label=status)
        pad.scatter(some["touchdown_east_m"], some["touchdown_north_m"], **look)
        wind.scatter(some["wind.mean_m_s"], some["touchdown_error_m"], **look)
    pad.set(xlabel="east of the middle, m", ylabel="north of the middle, m", aspect="equal")
    wind.set(xlabel="mean wind, m/s", ylabel="touch-down error, m", ylim=(0, None))
    wind.legend()
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    runs = kestrel.campaign.load(sys.argv[1]).runs
    plot(runs, sys.argv[2])
    wind = pd.cut(runs["wind.mean_m_s"], 4, precision=1).rename("wind")
    print(runs.groupby(wind)["touchdown_error_m"].describe(percentiles=[0.5, 0.95]).round(3).to_string())
