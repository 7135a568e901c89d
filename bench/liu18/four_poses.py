"""The simulation of [Liu18, 4.1]: four poses, ten features, two of them problematic.

The paper gives no numbers. Here the cameras are a step apart on a bent line and look up, 60 degrees above
the horizon, with f = 500 pixels. Eight features are 4 to 8 steps away. One is 10,000 steps away: no
parallax that could be measured. One is 6 steps above the first camera, straight along the world's y axis:
the direction in which PBA's azimuth has no effect. All features are seen by all cameras, with noise of half
a pixel. The first camera starts as it is, the others with errors of 0.01 radians and 0.05 steps; features
start from their rays.
"""

import math
import random

FOCAL = 500
PITCH = math.pi / 3
PIXEL_NOISE, ROTATION_ERROR, CENTRE_ERROR = 0.5, 0.01, 0.05
FAR, SINGULAR = 8, 9  # features


def product(R, v):
    return [sum(a * b for a, b in zip(row, v)) for row in R]


def rotation(phi):
    """exp(phi) by Rodrigues' formula."""
    angle = math.sqrt(sum(p * p for p in phi))
    x, y, z = (p / angle for p in phi)
    s, c = math.sin(angle), 1 - math.cos(angle)
    return [[1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y],
            [c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x],
            [c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y)]]


def bal_camera(phi, centre):
    """BAL's nine numbers of a camera without distortion: t = -R_cw P."""
    return [*phi, *(-t for t in product(rotation(phi), centre)), FOCAL, 0, 0]


def project(camera, X):
    x, y, z = (a + t for a, t in zip(product(rotation(camera[:3]), X), camera[3:6]))
    return [-FOCAL * x / z, -FOCAL * y / z]


def poses(draw):
    """Four cameras [rotation vector, centre]; R_cw turns the world about x by minus the pitch."""
    return [[[-PITCH + draw.gauss(0, 0.02), draw.gauss(0, 0.02), draw.gauss(0, 0.02)],
             [j, 0.1 * j * j, draw.gauss(0, 0.1)]] for j in range(4)]


def features(first_centre, draw):
    """Along rays that leave the middle of the path in a cone about the cameras' view."""
    def at(distance):
        right, up = draw.uniform(-0.4, 0.4), draw.uniform(-0.4, 0.4)
        ahead = [right, math.sin(PITCH) + up * math.cos(PITCH), -math.cos(PITCH) + up * math.sin(PITCH)]
        return [p + distance * a for p, a in zip((1.5, 0, 0), ahead)]
    x, y, z = first_centre
    return [at(draw.uniform(4, 8)) for _ in range(FAR)] + [at(1e4), [x, y + 6, z]]


def bal_text(cameras, points, pixels):
    lines = [f"{len(cameras)} {len(points)} {len(pixels)}"]
    lines += [f"{j} {i} {u!r} {v!r}" for (j, i), (u, v) in pixels.items()]
    lines += [repr(float(value)) for block in cameras + points for value in block]
    return "\n".join(lines) + "\n"


def write(seed, start_file, truth_file):
    """Two BAL files with the same noisy observations."""
    draw = random.Random(seed)
    true_poses = poses(draw)
    points = features(true_poses[0][1], draw)
    cameras = [bal_camera(*pose) for pose in true_poses]
    pixels = {(j, i): [u + draw.gauss(0, PIXEL_NOISE) for u in project(camera, X)]
              for i, X in enumerate(points) for j, camera in enumerate(cameras)}
    start = [cameras[0]]
    for phi, centre in true_poses[1:]:
        start.append(bal_camera([p + draw.gauss(0, ROTATION_ERROR) for p in phi],
                                [p + draw.gauss(0, CENTRE_ERROR) for p in centre]))
    start_file.write_text(bal_text(start, points, pixels))
    truth_file.write_text(bal_text(cameras, points, pixels))
