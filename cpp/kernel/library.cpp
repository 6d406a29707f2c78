// Reads the kernel library files and keeps them.
#include "kernel/library.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <map>
#include <mutex>

#include "error.h"
#include "kernel/assemble.h"

namespace irt::kernel {
namespace {

std::mutex mutex;
std::string directory;
std::map<std::string, std::string> files;

}  // namespace

void set_directory(const std::string& path) {
  const std::lock_guard lock(mutex);
  directory = path;
  files.clear();
}

const std::string& library_file(const std::string& name) {
  const std::lock_guard lock(mutex);
  const auto it = files.find(name);
  if (it != files.end()) return it->second;
  std::ifstream in(directory + "/" + name, std::ios::binary);
  if (!in) throw Error(fmt::format("the kernel file {} is missing from {}; reinstall implicitrt", name, directory));
  return files[name] = std::string(std::istreambuf_iterator<char>(in), {});
}

}  // namespace irt::kernel
