// The normal at a point of the surface, from the gradient of f there.
typedef struct {
  F x, y, z;  // unit, towards the viewer; nan where there is no gradient
  I front;    // the side of the viewer is that where f > 0
} NORMAL;

// For the lanes that `found` a point with the gradient g; v: unit, towards the eye.
static inline NORMAL normal_along(F gx, F gy, F gz, I found, F vx, F vy, F vz) {
  NORMAL n;
  n.x = n.y = n.z = (F)NAN;
  // Scaled first: squares of large or small gradients leave the range of reals.
  const F largest = max(max(fabs(gx), fabs(gy)), fabs(gz)), scale = R(1.0) / largest;
  const F x = gx * scale, y = gy * scale, z = gz * scale;
  const F facing = fma(x, vx, fma(y, vy, z * vz));
  n.front = GE(facing, (F)0);
  const F unit = SELECT(n.front, (F)1, (F)-1) / sqrt(fma(x, x, fma(y, y, z * z)));
  const I good = found & GT(largest, (F)TINY) & LT(largest, INF);
  n.x = SELECT(good, x * unit, n.x);
  n.y = SELECT(good, y * unit, n.y);
  n.z = SELECT(good, z * unit, n.z);
  return n;
}

#if !IRT_GRADIENT_FOUND
// The same for the point at s.
static inline NORMAL normal_at(const RAY* ray, F s, I found, F vx, F vy, F vz PARAMETERS) {
  F gx = (F)0, gy = (F)0, gz = (F)0;
  if (ANY(found))
    irt_gradient(fma(s, ray->dx, ray->px), fma(s, ray->dy, ray->py), fma(s, ray->dz, ray->pz) PARAMETERS_PASS, &gx, &gy, &gz);
  return normal_along(gx, gy, gz, found, vx, vy, vz);
}
#endif
