// Choices between affine forms: one of them where the condition is decided, else the range of both.
static inline RA ra_select(TRI c, RA a, RA b, IA result) {
  const RA box = ra_from_range(result), other = RA_PICK(c.no, b, box);
  return RA_PICK(c.yes, a, other);
}
