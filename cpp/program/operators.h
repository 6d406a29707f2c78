// The operator table: everything about an operator that code generation needs, in one place.
#pragma once

#include "program/program.h"

namespace irt::program {

// Templates of OpenCL C; $a $b $c stand for the operands, $r for the result, $v for the constant exponent.
struct Operator {
  Code code;
  const char* name;      // in comments of generated kernels
  int arity;
  const char* point;     // the value at a point
  const char* partials;  // its partial derivatives, one for each operand, separated by ';' ("" : zero)
  const char* interval;  // helper of kernels/interval*.cl
  const char* interval_file;
  const char* affine;    // helper of kernels/affine*.cl; nullptr: the interval helper on ranges
  const char* affine_file;
  bool partial;          // the interval helper reports where the operator is undefined and where it may jump
  bool ranged = false;   // the affine helper takes ranges of the operands and of the result, too
};

const Operator& describe(Code code);

// The range of an operand as the helper of an exponential is to take it: not above zero where the operand never is, whatever arithmetic adds.
std::string exponent_range(const Program& program, Value v, const std::string& range);

}  // namespace irt::program
