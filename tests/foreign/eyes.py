"""What the foreign renderers share: where their cameras stand, the faults of a stereo camera, and the capture that is left for impedraw
(docs/capture.md). Needs NumPy alone."""
import json
import pathlib
import struct
import zlib

import numpy

# As of a RealSense D435 (its data sheet, 337029-013): depth of 848 × 480 px, 50 mm between its imagers.
WIDTH, HEIGHT, FX, FY, CX, CY, BASELINE = 848, 480, 421.3, 422.1, 426.7, 237.4, 0.05
FAULTS = {
    "sigma_at_1m": 0.0015,  # [m]
    "correlation": 1.5,  # [px], standard deviation of the smoothing: a stereo matcher compares windows
    "disparity_step": 1 / 32,  # [px], of the D4 processor
    "dropout_deg": 75.0,  # steeper to the ray, most pixels measure nothing
    "dropout": 0.01,  # share of all other pixels
    "flying": 0.7,  # share of the pixels beside an edge that measure something between
    "shift": 1e-3,  # [m] of the camera's pose
    "turn_deg": 0.3,
}


def look_at(eye, at):
    """The pose of a camera, x to the right, y down, z forward: R, p."""
    z = numpy.subtract(at, eye) / numpy.linalg.norm(numpy.subtract(at, eye))
    x = numpy.cross(z, (0, 0, 1))
    x /= numpy.linalg.norm(x)
    return numpy.stack([x, numpy.cross(z, x), z], 1), numpy.array(eye)


def cameras(about, distance=0.62, height=0.50):
    """Three of them round the drawing, not over the arm."""
    for azimuth in numpy.radians((55, 180, 305)):
        side = numpy.sqrt(distance**2 - height**2)
        yield look_at(numpy.add(about, (side * numpy.cos(azimuth), side * numpy.sin(azimuth), height)), about)


def turn(axis, angle):
    a = axis / numpy.linalg.norm(axis)
    K = numpy.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return numpy.eye(3) + numpy.sin(angle) * K + (1 - numpy.cos(angle)) * K @ K


def quaternion(R):
    w = numpy.array([1 + s @ numpy.diag(R) for s in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))])
    k = w.argmax()
    off = ((R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]), (R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]))
    rows = ((w[0], *off[0]), (off[0][0], w[1], off[1][0], off[1][1]), (off[0][1], off[1][0], w[2], off[1][2]), (off[0][2], off[1][1], off[1][2], w[3]))
    q = numpy.array(rows[k])
    return q / numpy.linalg.norm(q)


def disturbed(depth, random):
    """A perfect depth image [m], 0: nothing, as a stereo camera sees it."""
    f = FAULTS
    z, seen = depth.copy(), depth > 0
    beside = numpy.roll(depth, 1, axis=1)
    flying = (numpy.abs(beside - depth) > 0.02) & seen & (beside > 0) & (random.random(z.shape) < f["flying"])
    share = random.random(z.shape)
    z[flying] = (share * depth + (1 - share) * beside)[flying]
    noise = random.normal(size=z.shape)
    kernel = numpy.exp(-0.5 * (numpy.arange(-5, 6) / f["correlation"]) ** 2)
    for axis in (0, 1):
        noise = numpy.apply_along_axis(numpy.convolve, axis, noise, kernel, "same")
    z += f["sigma_at_1m"] * depth**2 * noise / noise.std()
    disparity = numpy.round(FX * BASELINE / numpy.maximum(z, 1e-3) / f["disparity_step"]) * f["disparity_step"]
    z = FX * BASELINE / numpy.maximum(disparity, 1e-3)
    slope = numpy.hypot(*numpy.gradient(depth)) > numpy.tan(numpy.radians(f["dropout_deg"])) * depth / FX
    lost = (slope & (random.random(z.shape) < 0.7)) | (random.random(z.shape) < f["dropout"])
    z[lost | ~seen] = 0
    return z


def write_png(file, values):
    """16-bit grey."""
    rows = b"".join(b"\0" + row.tobytes() for row in values.astype(">u2"))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", values.shape[1], values.shape[0], 16, 0, 0, 0, 0)
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 3)) + chunk(b"IEND", b""))


def write_capture(folder, images, poses, joints, seed=None, lens=(FX, FY, CX, CY)):
    """images: uint16 in mm, or, with a seed for its faults, float in m, 0: nothing. The faulty cameras do not stand where they say."""
    fx, fy, cx, cy = lens
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    random, views = numpy.random.default_rng(seed), []
    for k, (image, (R, p)) in enumerate(zip(images, poses)):
        if seed is not None:
            image = numpy.round(1e3 * disturbed(image, random)).astype(numpy.uint16)
            axis, way = random.normal(size=3), random.normal(size=3)
            R, p = turn(axis, numpy.radians(FAULTS["turn_deg"])) @ R, p + FAULTS["shift"] * way / numpy.linalg.norm(way)
        write_png(folder / f"depth_{k}.png", image)
        views.append({
            "depth": f"depth_{k}.png", "depth_scale": 0.001, "width": WIDTH, "height": HEIGHT, "fx": fx, "fy": fy, "cx": cx, "cy": cy,
            "X_WC": {"p": list(p), "q_wxyz": list(quaternion(R))}, "joints": list(joints),
        })  # fmt: skip
    (folder / "capture.json").write_text(json.dumps({"format": "impedraw-capture", "version": 1, "views": views}, indent=1))
