// The kernel of a call: ray, clip, root, normal, colour, for one packet of rays. Only what was asked for is compiled.
__kernel void trace(RAY_DECL, __global const real* q, const int pitch, const int max_pieces,
#if IRT_NORMAL
                    __global float* normal, const int plane,
#endif
#if IRT_RGB
                    __global uint* rgba, const uint background,
#endif
#if IRT_PIECES
                    __global uint* pieces,
#endif
                    __global real* depth, __global real* uncertainty, __global uchar* status ARGUMENTS, const int first_column, const int first_row) {
  const size_t column = first_column + get_global_id(0), row = first_row + get_global_id(1), at = row * pitch + column * W;
  const RAY ray = make_ray(RAY_PASS, q, column, row);
  const RANGE range = clip_ray(&ray, q);
  const ROOT root = find_root(&ray, &range, q, max_pieces FINDER_PASS);
  const I found = EQ(root.status, HIT) | EQ(root.status, TOUCH);
  const F s = NARROW(root.at), t = max(NARROW((ray.tau + root.at) * ray.length), (F)0), length = NARROW(ray.length);
  // Half the width of the bracket, and the rounding of t.
#if IRT_SPLIT
  const F bracket = fma(root.half_width, length * (R(1.0) + R(4.0) * ULP), R(0.75) * ULP * t + (F)POSITION_PAD);
#else
  const F bracket = fma(root.half_width, length * (R(1.0) + R(4.0) * ULP), R(4.0) * ULP * (t + (F)POSITION_PAD));
#endif
  STORE(SELECT(EQ(root.status, MISS), INF, t), depth + at);
  STORE_BYTES(root.status, status + at);
#if IRT_PIECES
  STORE_UINT(TO_UINT(root.pieces), pieces + at);
#endif
#if IRT_OUTWARD
  STORE(SELECT(EQ(root.status, HIT), bracket, (F)NAN), uncertainty + at);
#else
  STORE((F)NAN, uncertainty + at);
#endif
#if IRT_NORMAL || IRT_RGB
  const F none = (F)NAN, less = R(1.0) / length;
  const F vx = -ray.dx * less, vy = -ray.dy * less, vz = -ray.dz * less;
  F nx = none, ny = none, nz = none;
  I front = ALL;
  if (ANY(found)) {
#if IRT_GRADIENT_FOUND
    const F gx = root.gx, gy = root.gy, gz = root.gz;
#else
    F gx, gy, gz;
    irt_gradient(fma(s, ray.dx, ray.px), fma(s, ray.dy, ray.py), fma(s, ray.dz, ray.pz) PARAMETERS_PASS, &gx, &gy, &gz);
#endif
    // Scaled first: squares of large or small gradients leave the range of reals.
    const F largest = max(max(fabs(gx), fabs(gy)), fabs(gz)), scale = R(1.0) / largest;
    const F x = gx * scale, y = gy * scale, z = gz * scale;
    const F facing = fma(x, vx, fma(y, vy, z * vz));
    front = GE(facing, (F)0);
    const F unit = SELECT(front, (F)1, (F)-1) / sqrt(fma(x, x, fma(y, y, z * z)));
    const I good = found & GT(largest, (F)TINY) & LT(largest, INF);
    nx = SELECT(good, x * unit, none);
    ny = SELECT(good, y * unit, none);
    nz = SELECT(good, z * unit, none);
  }
#endif
#if IRT_NORMAL
  STORE_FLOAT(nx, normal + at);
  STORE_FLOAT(ny, normal + (size_t)plane + at);
  STORE_FLOAT(nz, normal + 2 * (size_t)plane + at);
#endif
#if IRT_RGB
  STORE_UINT(shade(root.status, front, nx, ny, nz, vx, vy, vz, background, q), rgba + at);
#endif
}
