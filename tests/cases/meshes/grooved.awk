# A block of l × w × h unit cubes with a groove around it in each of three directions: without the
# outer cubes at x = a, y = b or z = c. OBJ.

function is_kept(x, y, z) {
    if (x < 0 || y < 0 || z < 0 || x >= l || y >= w || z >= h) return 0
    if ((x == 0 || x == l - 1) && (y == b || z == c)) return 0
    if ((y == 0 || y == w - 1) && (x == a || z == c)) return 0
    return !((z == 0 || z == h - 1) && (x == a || y == b))
}

function corner(x, y, z,    place) {
    place = x " " y " " z
    if (!(place in numbers)) {
        numbers[place] = ++count
        print "v " place
    }
    return numbers[place]
}

# The side of a cube towards `sign` along an axis, counter-clockwise from outside.
function side(x, y, z, axis, sign,    at, i, u, v, text) {
    for (i = 0; i < 4; i++) {
        u = (i == 1 || i == 2)
        v = (i > 1)
        at[axis] = sign > 0
        at[(axis + 1) % 3] = sign > 0 ? u : v
        at[(axis + 2) % 3] = sign > 0 ? v : u
        text = text " " corner(x + at[0], y + at[1], z + at[2])
    }
    print "f" text
}

BEGIN {
    for (x = 0; x < l; x++) for (y = 0; y < w; y++) for (z = 0; z < h; z++) {
        if (!is_kept(x, y, z)) continue
        for (sign = -1; sign < 2; sign += 2) {
            if (!is_kept(x + sign, y, z)) side(x, y, z, 0, sign)
            if (!is_kept(x, y + sign, z)) side(x, y, z, 1, sign)
            if (!is_kept(x, y, z + sign)) side(x, y, z, 2, sign)
        }
    }
}
