#include <raybundle/linalg/control_group.h>

#include <raybundle/linalg/system_file.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <limits>
#include <vector>

namespace raybundle::linalg {
namespace {

constexpr double no_limit = std::numeric_limits<double>::max();

/// What a version calls its figures of memory.
struct MemoryNames {
  const char* controller;
  const char* limit;
  const char* usage;
  const char* unused_files;  // a line of memory.stat
};
constexpr std::array<MemoryNames, 2> versions = {
    {{"memory", "/memory.limit_in_bytes", "/memory.usage_in_bytes", "total_inactive_file"},
     {"", "/memory.max", "/memory.current", "inactive_file"}}};

/// The folders of this process's group and of those above it: of a controller of version 1, each of
/// which has groups of its own, or without a name of version 2. Not all need be there: a container
/// may be told its path on the host, and see its own group as the top.
std::vector<std::string> groups(const std::string& root, const std::string& controller) {
  std::ifstream file(root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {  // number:controller,controller:path
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    if (controllers.find("," + controller + ",") == std::string::npos) continue;
    const std::string top = root + "/sys/fs/cgroup" + (controller.empty() ? "" : "/" + controller);
    const std::string path = line.substr(second + 1);
    std::vector<std::string> folders = {top};
    for (std::size_t end = 0; end + 1 < path.size();) {
      end = std::min(path.find('/', end + 1), path.size());
      folders.push_back(top + path.substr(0, end));
    }
    return folders;
  }
  return {};
}

double memory_of_group(const std::string& folder, const MemoryNames& names) {
  constexpr double absurd = 0x1p62;  // how version 1 says that there is no limit
  const double limit = number_in(folder + names.limit).value_or(no_limit);
  if (limit < 0 || limit >= absurd) return no_limit;
  const double usage = number_in(folder + names.usage).value_or(0);
  const double unused = number_in(folder + "/memory.stat", names.unused_files).value_or(0);
  return std::clamp(limit - (usage - unused), 0.0, limit);
}

double processors_of_group(double quota, double period) {
  return quota > 0 && period > 0 ? quota / period : no_limit;
}

}  // namespace

double control_group_memory(const std::string& root) {
  double least = no_limit;
  for (const MemoryNames& names : versions) {
    for (const std::string& folder : groups(root, names.controller)) {
      least = std::min(least, memory_of_group(folder, names));
    }
  }
  return least;
}

double control_group_processors(const std::string& root) {
  double least = no_limit;
  for (const std::string& folder : groups(root, "cpu")) {
    const double quota = number_in(folder + "/cpu.cfs_quota_us").value_or(0);
    const double period = number_in(folder + "/cpu.cfs_period_us").value_or(0);
    least = std::min(least, processors_of_group(quota, period));
  }
  for (const std::string& folder : groups(root, "")) {
    std::ifstream file(folder + "/cpu.max");
    double quota = 0, period = 0;
    if (file >> quota >> period) least = std::min(least, processors_of_group(quota, period));
  }
  return least;
}

}  // namespace raybundle::linalg
