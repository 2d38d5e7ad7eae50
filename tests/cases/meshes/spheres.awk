# Points on spheres: `awk -v count=COUNT [-v objects=OBJECTS] -f spheres.awk`. Each object has a triangle.
BEGIN {
    for (object = 0; object < (objects ? objects : 1); object++) {
        if (objects) print "o part", object
        for (i = 0; i < count; i++) {
            z = 1 - (2 * i + 1) / count
            radius = sqrt(1 - z * z)
            print "v", object % 20 * 2 + radius * cos(2.4 * i), int(object / 20) * 2 + radius * sin(2.4 * i), z
        }
        if (objects) print "f -1 -2 -3"
    }
}
