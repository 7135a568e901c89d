"""Where cameras are: read from BAL files, aligned, and looked at along the direction in which they spread least."""

import math


def centres(file):
    """Camera centres -R^T t of a BAL file."""
    with open(file, encoding="utf-8") as lines:
        cameras, _, count = map(int, lines.readline().split())
        for _ in range(count):
            lines.readline()
        numbers = [float(word) for word in lines.read().split()[:9 * cameras]]
    return [centre(numbers[9 * i:9 * i + 3], numbers[9 * i + 3:9 * i + 6]) for i in range(cameras)]


def centre(turn, t):
    """-Exp(-turn) t, by Rodrigues' formula."""
    angle = math.sqrt(dot(turn, turn))
    if angle == 0:
        return [-x for x in t]
    axis = [-x / angle for x in turn]
    along, across = dot(axis, t), cross(axis, t)
    c, s = math.cos(angle), math.sin(angle)
    return [-(c * t[k] + s * across[k] + (1 - c) * along * axis[k]) for k in range(3)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def times(matrix, x):
    return [dot(row, x) for row in matrix]


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def largest_eigenvector(matrix, without=None):
    """Of a symmetric positive matrix, at right angles to `without`: by squaring it again and again."""
    if without:
        off = [[(i == j) - x * y for j, y in enumerate(without)] for i, x in enumerate(without)]
        matrix = product(off, product(matrix, off))
    for _ in range(60):
        largest = max(abs(x) for row in matrix for x in row) or 1
        matrix = [[x / largest for x in row] for row in matrix]
        matrix = product(matrix, matrix)
    column = max(matrix, key=lambda row: dot(row, row))
    length = math.sqrt(dot(column, column)) or 1
    return [x / length for x in column]


def mean(points):
    return [sum(p[k] for p in points) / len(points) for k in range(3)]


def aligned(points, to):
    """`points` after the similarity that takes them nearest to `to`: Horn's quaternion."""
    a, b = mean(points), mean(to)
    p = [[x - y for x, y in zip(each, a)] for each in points]
    q = [[x - y for x, y in zip(each, b)] for each in to]
    S = [[sum(x[i] * y[j] for x, y in zip(p, q)) for j in range(3)] for i in range(3)]
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = S
    N = [[xx + yy + zz, yz - zy, zx - xz, xy - yx], [yz - zy, xx - yy - zz, xy + yx, zx + xz],
         [zx - xz, xy + yx, yy - xx - zz, yz + zy], [xy - yx, zx + xz, yz + zy, zz - xx - yy]]
    shift = sum(abs(x) for row in N for x in row)  # so that no eigenvalue is below 0
    w, x, y, z = largest_eigenvector([[N[i][j] + (shift if i == j else 0) for j in range(4)] for i in range(4)])
    R = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    turned = [times(R, each) for each in p]
    scale = sum(dot(u, v) for u, v in zip(turned, q)) / (sum(dot(u, u) for u in turned) or 1)
    return [[scale * u + v for u, v in zip(each, b)] for each in turned]


def from_above(places, *others):
    """Each list of points along the two directions in which `places` spread most."""
    middle = mean(places)
    offsets = [[x - y for x, y in zip(each, middle)] for each in places]
    spread = [[sum(p[i] * p[j] for p in offsets) for j in range(3)] for i in range(3)]
    first = largest_eigenvector(spread)
    second = largest_eigenvector(spread, first)
    return [[(dot([x - y for x, y in zip(each, middle)], first), dot([x - y for x, y in zip(each, middle)], second))
             for each in points] for points in (places, *others)]
