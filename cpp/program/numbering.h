// Value numbering: a program grows by instructions that it does not have yet.
#pragma once

#include <map>
#include <tuple>

#include "program/operators.h"
#include "program/program.h"

namespace irt::program {

class Numbering {
 public:
  explicit Numbering(Program& program) : program_(program) {
    for (std::size_t i = 0; i < program.code.size(); ++i) known_[key(program.code[i])] = static_cast<Value>(i);
  }

  // The value of an instruction, which is partial where an operand is. Callers say what is never negative.
  Value emit(Instruction i) {
    i.nonpositive = never_positive(i);
    i.partial = describe(i.code).partial;
    for (const Value v : {i.a, i.b, i.c})
      if (v >= 0) i.partial = i.partial || program_[v].partial;
    const auto [it, fresh] = known_.emplace(key(i), static_cast<Value>(program_.code.size()));
    if (fresh) program_.code.push_back(i);
    return it->second;
  }

 private:
  bool never_positive(const Instruction& i) const {
    const auto below = [&](Value v) { return program_[v].nonpositive; };
    const auto above = [&](Value v) { return program_[v].nonnegative; };
    switch (i.code) {
      case Code::Constant: return i.value.hi <= 0;
      case Code::Neg: return above(i.a);
      case Code::Add:
      case Code::Max: return below(i.a) && below(i.b);
      case Code::Sub: return below(i.a) && above(i.b);
      case Code::Mul: return (below(i.a) && above(i.b)) || (above(i.a) && below(i.b));
      case Code::Min: return below(i.a) || below(i.b);
      default: return false;
    }
  }

  using Key = std::tuple<Code, Value, Value, Value, double, double, std::int64_t>;
  static Key key(const Instruction& i) { return {i.code, i.a, i.b, i.c, i.value.lo, i.value.hi, i.index}; }

  Program& program_;
  std::map<Key, Value> known_;
};

}  // namespace irt::program
