// Forward kinematics of a robot. A frame is a quaternion `q` (x, y, z, w) and a translation `t`.

function rotated([x, y, z, w], [a, b, c]) {
  // v + 2 w (u × v) + 2 u × (u × v)
  const [p, q, r] = [y * c - z * b, z * a - x * c, x * b - y * a].map((n) => 2 * n);
  return [a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p];
}

/** The frame `b`, which is given in `a`, in the parent of `a`. */
function composed(a, b) {
  const [x, y, z, w] = a.q, [i, j, k, l] = b.q;
  const q = [
    w * i + x * l + y * k - z * j,
    w * j - x * k + y * l + z * i,
    w * k + x * j - y * i + z * l,
    w * l - x * i - y * j - z * k,
  ];
  const moved = rotated(a.q, b.t);
  return { q, t: a.t.map((c, axis) => c + moved[axis]) };
}

/** The motion of a joint from its reference by a displacement. */
function motionOf(joint, displacement) {
  if (joint.motion === "slide") return { q: [0, 0, 0, 1], t: joint.axis.map((c) => c * displacement) };
  if (joint.motion !== "hinge") return { q: [0, 0, 0, 1], t: [0, 0, 0] };
  const sine = Math.sin(displacement / 2);
  const q = [...joint.axis.map((c) => c * sine), Math.cos(displacement / 2)];
  const moved = rotated(q, joint.anchor);
  return { q, t: joint.anchor.map((c, axis) => c - moved[axis]) };
}

/** Indices in an order in which each comes after the one that `leaderOf` names. */
function ordered(list, leaderOf) {
  const followers = list.map(() => []);
  const order = [];
  list.forEach((item, index) => {
    const leader = leaderOf(item);
    if (leader === null) order.push(index);
    else followers[leader].push(index);
  });
  for (let next = 0; next < order.length; next++) for (const index of followers[order[next]]) order.push(index);
  return order;
}

/** Displacements in which joints follow their leaders. */
function followed(joints, displacements) {
  const all = [...displacements];
  for (const index of ordered(joints, (joint) => joint.leader)) {
    const { coefficients, leader } = joints[index];
    if (!coefficients.length) continue;
    const at = leader === null ? 0 : all[leader];
    all[index] = coefficients.reduceRight((sum, coefficient) => sum * at + coefficient, 0);
  }
  return all;
}

/** Frames of all links in the world. */
function posesOf(links, joints, displacements) {
  const frames = links.map((link) => link.rest);
  joints.forEach((joint, index) => {
    frames[joint.link] = composed(frames[joint.link], motionOf(joint, displacements[index]));
  });
  for (const index of ordered(links, (link) => link.parent)) {
    const { parent } = links[index];
    if (parent !== null) frames[index] = composed(frames[parent], frames[index]);
  }
  return frames;
}

/** Columns of the affine map of a shape into the world: three axes, then the origin. */
function placed(frame, columns) {
  return columns.map((column, at) => {
    const moved = rotated(frame.q, column);
    return at < 3 ? moved : moved.map((c, axis) => c + frame.t[axis]);
  });
}
