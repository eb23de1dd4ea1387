"""Runs a sweep, kills its driver with SIGKILL at random moments, starts it again, until it ends.

    kill_driver.py SEED KILLS SECONDS COMMAND…    SECONDS: kills fall within the first SECONDS

Prints the moments, and the driver's largest resident memory [MB] of all starts.
"""

import random
import signal
import subprocess
import sys
import time


def run_and_kill(command: list[str], seed: int, kills: int, within: float) -> dict[str, object]:
    moments = [random.Random(f"{seed}/{i}").uniform(0.2, 1.0) * within for i in range(kills)]
    peak, killed = 0, []
    for moment in [*moments, None]:
        start = time.monotonic()
        driver = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        while driver.poll() is None:
            peak = max(peak, resident(driver.pid))
            if moment is not None and time.monotonic() - start > moment:
                driver.send_signal(signal.SIGKILL)
                driver.wait()
                killed.append(round(moment, 1))
                break
            time.sleep(0.05)
    return {"seed": seed, "killed": killed, "code": driver.returncode, "peak_mb": peak / 1e6}


def resident(process: int) -> int:
    """Largest resident memory so far [B]."""
    try:
        with open(f"/proc/{process}/status", encoding="ascii") as file:
            for line in file:
                if line.startswith("VmHWM:"):
                    return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0


if __name__ == "__main__":
    print(run_and_kill(sys.argv[4:], int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])))
