#include <raybundle/linalg/memory.h>

#include <fstream>
#include <limits>

namespace raybundle::linalg {
namespace {

std::string gibibytes(double bytes) {
  std::string text = std::to_string(bytes / (1024.0 * 1024.0 * 1024.0));
  return text.substr(0, text.find('.') + 2) + " GiB";
}

}  // namespace

double available_memory() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  double kibibytes = 0;
  while (file >> key >> kibibytes) {
    if (key == "MemAvailable:") return kibibytes * 1024;
    std::getline(file, unit);
  }
  return std::numeric_limits<double>::max();
}

void require_memory(double bytes, const std::string& what) {
  const double available = available_memory();
  if (bytes <= available) return;
  throw MemoryRefusal(what + " needs " + gibibytes(bytes) + ", and " + gibibytes(available) +
                      " are available");
}

}  // namespace raybundle::linalg
