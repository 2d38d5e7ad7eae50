# Vertices of an OBJ file, each after the name of its hull. With -v places=N, coordinates of hulls whose name
# matches `rounded` have N decimal places.
/^o / { name = $2 }
/^v / {
    if (places && name ~ rounded) for (i = 2; i <= 4; i++) $i = sprintf("%.*f", places, $i + 10)
    print name, $2, $3, $4
}
