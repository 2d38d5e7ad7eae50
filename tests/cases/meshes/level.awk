# A rough floor of 6 x 6 squares in y-up, with two materials and a part without one.
BEGIN {
    for (z = 0; z < 7; z++) for (x = 0; x < 7; x++) printf "v %d %.3f %d\n", x, (7 * x + 5 * z) % 11 / 11, z
    for (z = 0; z < 6; z++) {
        if (z == 1) print "usemtl rock"
        if (z == 2) print "usemtl wet grass"
        for (x = 1; x < 7; x++) print "f", 7 * z + x, 7 * z + x + 7, 7 * z + x + 8, 7 * z + x + 1
    }
}
