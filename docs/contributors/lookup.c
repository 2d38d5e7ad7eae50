/* The look-up of FORMAT.md in C: sections, cell, leaf, best candidate. Compile with -ffp-contract=off. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

static uint32_t read_u32(const uint8_t *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* p: the payload. entry: where the section's entry is in the root. */
typedef struct { const uint8_t *at; uint32_t count; } section;

static section find(const uint8_t *p, uint64_t payload_len, uint32_t entry) {
    const uint8_t *e = p + payload_len - 152 + entry;
    return (section){ e + (int32_t)read_u32(e), read_u32(e + 4) };
}

typedef struct { uint32_t face, u, v; } cell;

/* Brings d into range and rounds it to f. */
static void narrow(double d[3], float f[3]) {
    float size = 0;
    for (int i = 0; i < 3; i++) size = fmaxf(size, fabsf(f[i] = (float)d[i]));
    if (size >= 1e-30f && size <= 1e30f) return;
    double largest = fmax(fmax(fabs(d[0]), fabs(d[1])), fabs(d[2]));
    int valid = largest > 0 && isfinite(d[0]) && isfinite(d[1]) && isfinite(d[2]);
    for (int i = 0; i < 3; i++) f[i] = (float)(d[i] = valid ? d[i] / largest : i == 0); /* invalid: any direction will do */
}

static uint32_t grid(float t) {
    float g = rintf(t * 4194303.0f) + 4194304.0f;
    return g >= 0.0f && g < 8388608.0f ? (uint32_t)g : 0; /* NaN: any value below 2^23 will do */
}

static cell locate(const float f[3]) {
    float x = fabsf(f[0]), y = fabsf(f[1]), z = fabsf(f[2]);
    uint32_t axis = z > x && z > y ? 2 : y > x ? 1 : 0;
    float size = fabsf(f[axis]);
    return (cell){ 2 * axis + (signbit(f[axis]) ? 1 : 0),
                   grid(f[(axis + 1) % 3] / size), grid(f[(axis + 2) % 3] / size) };
}

typedef struct { uint32_t first, count, nodes; } leaf;

/* Index of the part that contains d, of planes + 1 parts: behind or in front of one plane, or in a bundle of seven. */
static uint32_t part(const uint32_t *normals, uint32_t planes, const double d[3]) {
    uint32_t k = 0;
    while (k < planes) {
        double n[3];
        for (uint32_t i = 0; i < 3; i++) memcpy(&n[i], normals + 2 * (i * planes + k), sizeof n[i]);
        k = 2 * k + (n[0] * d[0] + n[1] * d[1] + n[2] * d[2] > 0.0 ? 2 : 1);
    }
    return k - planes;
}

static double read_f64(const uint32_t *at) {
    double value;
    memcpy(&value, at, sizeof value);
    return value;
}

static double dot3(const uint32_t *n, const double d[3]) {
    return read_f64(n) * d[0] + read_f64(n + 2) * d[1] + read_f64(n + 4) * d[2];
}

/* Index of the step of a fan that contains d. */
static uint32_t step(const uint32_t *head, const double d[3]) {
    double x = dot3(head, d), y = dot3(head + 6, d);
    int steep = fabs(y) > fabs(x);
    double rise = steep ? -x : y, run = steep ? y : x;
    double angle = rise / run + 2.0 * (steep + 2 * (run < 0.0));
    double at = (angle - read_f64(head + 12)) * read_f64(head + 14);
    uint32_t last = (1u << head[16]) - 1;
    return at >= last ? last : at > 0.0 ? (uint32_t)at : 0; /* NaN, on the axis: 0 */
}

/* slots: the hull's run as u32; kind, resolution, leaf_blocks, block_count: from its record and spans.
   d and f: from narrow. */
static leaf find_leaf(const uint32_t *slots, uint32_t kind, uint32_t resolution, uint32_t leaf_blocks,
                      uint32_t block_count, const double d[3], const float f[3]) {
    if (kind == 0) return (leaf){ 0, block_count, 0 };
    cell c = locate(f);
    uint64_t root = c.face;
    if (kind == 1) {
        uint64_t column = (uint64_t)c.u * resolution >> 23, row = (uint64_t)c.v * resolution >> 23;
        root = ((uint64_t)c.face * resolution + row) * resolution + column;
    }
    uint32_t left[2] = { 23, 23 }; /* bits of u and v not used yet */
    uint32_t nodes = 0, slot = slots[root];
    for (;;) {
        uint32_t rest = slot & 0x3fffffff;
        switch (slot >> 30) {
        case 0: /* branch */
            if (kind == 2) {
                uint32_t by_v = left[0] < left[1];
                slot = slots[rest + ((by_v ? c.v : c.u) >> --left[by_v] & 1)];
            } else {
                uint32_t b = rest & 15, mask = (1u << b) - 1;
                left[0] -= b;
                slot = slots[(rest >> 4) + ((c.v >> left[0] & mask) << b) + (c.u >> left[0] & mask)];
            }
            break;
        case 1: /* plain leaf */
            return (leaf){ rest, leaf_blocks, nodes };
        case 2: { /* planes, or a fan */
            const uint32_t *at = slots + (rest >> 2);
            uint32_t planes = rest & 1 ? 7 : 1;
            slot = rest & 2 ? at[17 + step(at, d)] : at[6 * planes + part(at, planes, d)];
            break;
        }
        default: /* listed leaf */
            return (leaf){ slots[rest], slots[rest + 1], nodes };
        }
        nodes++;
    }
}

/* blocks: the hull's run, 32 words each, the first 24 of them f32. Returns the vertex index. */
static uint32_t best(const uint32_t *blocks, leaf l, const double d[3]) {
    const uint32_t *found = blocks + 32 * (size_t)l.first; /* lane 0 of the first block */
    double greatest = -INFINITY;
    for (uint32_t b = 0; b < l.count; b++) {
        for (uint32_t lane = 0; lane < 8; lane++) {
            const uint32_t *at = blocks + 32 * ((size_t)l.first + b) + lane;
            float p[3];
            for (int i = 0; i < 3; i++) memcpy(&p[i], at + 8 * i, 4);
            double dot = p[0] * d[0] + p[1] * d[1] + p[2] * d[2];
            if (dot > greatest) greatest = dot, found = at;
        }
    }
    return found[24];
}
