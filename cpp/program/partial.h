// Masks that go along with enclosures: where a value is undefined (u) and where it may be undefined or jump (r).
// Only values whose operators can do so have masks; most programs have none.
#pragma once

#include <string>

#include "program/emit.h"

namespace irt::program {

// Appends the statements of an operator that reports masks, or of a condition, or of a choice, for intervals; a, b, c
// are the operands as text, and results are named with the prefix. False where the instruction is of another kind, and nothing is appended.
bool emit_masked(const Program& program, Value v, const std::string& a, const std::string& b, const std::string& c,
                 Precision precision, char prefix, std::string& text);

// Appends the masks that v inherits from its operands.
void emit_inherited(const Program& program, Value v, std::string& text);

// The statements that hand the masks of the result to the caller.
std::string finish_masks(const Program& program);

// Those that tell whether the piece lies in the clip region and whether f can be zero at all, from the intervals of Program::clip and
// Program::numerator; "" in programs with neither.
std::string finish_region(const Program& program, const std::string& clip, const std::string& numerator);

}  // namespace irt::program
