// The files of kernels/, read once.
#pragma once

#include <string>

namespace irt::kernel {

const std::string& library_file(const std::string& name);

}  // namespace irt::kernel
