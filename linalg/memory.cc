#include <raybundle/linalg/memory.h>

#include <algorithm>
#include <fstream>
#include <limits>

namespace raybundle::linalg {
std::string memory_text(double bytes) {
  constexpr double mebi = 1024.0 * 1024.0;
  const bool large = bytes >= 1024 * mebi;
  const std::string text = std::to_string(bytes / (large ? 1024 * mebi : mebi));
  return text.substr(0, text.find('.') + 2) + (large ? " GiB" : " MiB");
}

double resident_memory() {
  std::ifstream file("/proc/self/status");
  for (std::string key; file >> key;) {
    double kibibytes = 0;
    if (key == "VmRSS:" && file >> kibibytes) return kibibytes * 1024;
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0;
}

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
  throw MemoryRefusal(what + " needs " + memory_text(bytes) + ", and " + memory_text(available) +
                      " are available");
}

void require_memory(double bytes, double left, const std::string& what) {
  if (bytes <= left) return;
  throw MemoryRefusal(what + " needs " + memory_text(bytes) + ", and beside all else " +
                      memory_text(std::max(0.0, left)) + " are left");
}

}  // namespace raybundle::linalg
