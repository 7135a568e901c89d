#include <raybundle/tools/memory.h>

#include <sys/resource.h>

#include <raybundle/linalg/system_file.h>

namespace raybundle::tools {

// The figure of getrusage() survives exec() and may be that of a larger parent; the kernel's
// high-water mark is this program's own.
std::int64_t peak_memory() {
  if (const auto kibibytes = linalg::number_in("/proc/self/status", "VmHWM:")) {
    return static_cast<std::int64_t>(*kibibytes) * 1024;
  }
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

}  // namespace raybundle::tools
