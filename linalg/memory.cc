#include <raybundle/linalg/memory.h>

#include <raybundle/linalg/control_group.h>
#include <raybundle/linalg/system_file.h>

#include <sys/resource.h>

#include <algorithm>
#include <limits>

namespace raybundle::linalg {
namespace {

constexpr double no_limit = std::numeric_limits<double>::max();

double bytes_of_process(const char* key) {
  return 1024 * number_in("/proc/self/status", key).value_or(0);
}

/// What a limit of this process leaves, `key` being what counts towards it.
double left_of_limit(decltype(RLIMIT_DATA) resource, const char* key) {
  rlimit limit = {};
  if (::getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return no_limit;
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - bytes_of_process(key));
}

}  // namespace

std::string memory_text(double bytes) {
  const double unit = bytes >= 1e9 ? 1e9 : bytes >= 1e6 ? 1e6 : 1e3;
  const std::string text = std::to_string(bytes / unit);
  return text.substr(0, text.find('.') + 2) + (unit == 1e9 ? " GB" : unit == 1e6 ? " MB" : " kB");
}

double resident_memory() { return bytes_of_process("VmRSS:"); }

double available_memory() {
  const auto kibibytes = number_in("/proc/meminfo", "MemAvailable:");
  return std::min({kibibytes ? 1024 * *kibibytes : no_limit, control_group_memory(),
                   left_of_limit(RLIMIT_DATA, "VmData:"), left_of_limit(RLIMIT_AS, "VmSize:")});
}

void require_memory(double bytes, const std::string& what) {
  const double available = available_memory();
  if (bytes <= available) return;
  throw MemoryRefusal(what + " needs " + memory_text(bytes) + ", and " + memory_text(available) +
                      " are available");
}

void require_memory(double bytes, double left, const std::string& what) {
  if (bytes <= left) return;
  throw MemoryRefusal(what + " needs " + memory_text(bytes) + ", and beside all else " +
                      memory_text(std::max(0.0, left)) + " are left");
}

}  // namespace raybundle::linalg
