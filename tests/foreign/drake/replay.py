"""The floor of the real-time factor: a client that answers each status with the next torque of a recorded run, and computes nothing.

Usage: replay.py URL RECORDED.npz    (a file of simulate.py)
"""
import struct
import sys

import numpy
from pydrake.lcm import DrakeLcm

COMMAND = bytes.fromhex("ddc7c7738c815334")
recorded = numpy.load(sys.argv[2])
torques = recorded["torque"][recorded["began"]]
lcm = DrakeLcm(sys.argv[1])
received = []
lcm.Subscribe("IIWA_STATUS", lambda data: received.append(struct.unpack_from(">q", data, 8)[0]))
first = None
sent = 0
while sent < len(torques):
    if not lcm.HandleSubscriptions(5000):
        sys.exit("no status")
    while lcm.HandleSubscriptions(0):
        pass
    if first is None:
        first = received[-1]
    if received[-1] - first < 250000:
        continue
    lcm.Publish("IIWA_COMMAND", COMMAND + struct.pack(">qii7d", received[-1], 0, 7, *torques[sent]))
    sent += 1
