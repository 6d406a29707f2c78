// Shading: Blinn-Phong under a headlight and one directional light, in linear light, stored as sRGB.

// An sRGB byte by a polynomial of the root, within a fifth of a step of the exact curve.
static inline F encode(F linear) {
  const F c = clamp(linear, (F)0, (F)1), a = sqrt(c);
  const F curve = fma(fma(fma(fma((F)R(-0.30955966), a, (F)R(0.84274337)), a, (F)R(-0.94481101)), a, (F)R(1.44788189)), a, (F)R(-0.03700305));
  return floor(fma(SELECT(LT(c, (F)R(0.0031308)), R(12.92) * c, curve), (F)255, (F)R(0.5)));
}

// Blinn and Phong's cosine to the 32nd, where the surface faces the light.
static inline F highlight(F diffuse, F cosine) {
  const F g2 = cosine * cosine, g4 = g2 * g2, g8 = g4 * g4, g16 = g8 * g8, g32 = g16 * g16;
  return SELECT(GT(diffuse, (F)0), g32, (F)0);
}

// background: the pixel of a miss. v: unit, towards the eye; n: unit, towards the viewer, or nan, which is lit as if it faced the eye.
static inline UINT shade(I status, I front, F nx, F ny, F nz, F vx, F vy, F vz, const uint background,
                         __global const real* q) {
  const I hit = EQ(status, HIT) | EQ(status, TOUCH), open = EQ(status, UNRESOLVED);
  if (!ANY(hit | open)) return (UINT)background;
  const I odd = ~EQ(nx, nx);
  const F x = SELECT(odd, vx, nx), y = SELECT(odd, vy, ny), z = SELECT(odd, vz, nz);
  const F facing = max(fma(x, vx, fma(y, vy, z * vz)), (F)0);
  F diffuse = R(0.08) + R(0.5) * facing, gloss = R(0.12) * highlight(facing, facing);
  if (LIGHT_POWER != 0) {
    const F lit = max(fma(x, (F)LIGHT(0), fma(y, (F)LIGHT(1), z * (F)LIGHT(2))), (F)0);
    const F hx = vx + (F)LIGHT(0), hy = vy + (F)LIGHT(1), hz = vz + (F)LIGHT(2);
    const F along = fma(x, hx, fma(y, hy, z * hz)) / sqrt(max(fma(hx, hx, fma(hy, hy, hz * hz)), (F)R(1e-12)));
    diffuse += (F)LIGHT_POWER * R(0.55) * lit;
    gloss += (F)LIGHT_POWER * R(0.25) * highlight(lit, max(along, (F)0));
  }
  UINT pixel = (UINT)0;
  for (int k = 0; k < 3; ++k) {
    const F surface = fma(SELECT(front, (F)COLOR(k), (F)BACK_COLOR(k)), diffuse, gloss);
    const F linear = SELECT(open, (F)UNRESOLVED_COLOR(k), surface);
    pixel |= TO_UINT(encode(linear)) << (UINT)(8 * k);
  }
  const UINT drawn = TO_UINT(hit | open);
  return (drawn & (pixel | (UINT)0xff000000u)) | (~drawn & (UINT)background);
}
