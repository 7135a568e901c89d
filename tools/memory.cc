#include <raybundle/tools/memory.h>

#include <sys/resource.h>

#include <fstream>
#include <limits>
#include <string>

namespace raybundle::tools {

// The figure of getrusage() survives exec() and may be that of a larger parent; the kernel's
// high-water mark is this program's own.
std::int64_t peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::int64_t kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024;
    status.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

}  // namespace raybundle::tools
