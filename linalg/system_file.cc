#include <raybundle/linalg/system_file.h>

#include <fstream>
#include <limits>

namespace raybundle::linalg {

std::optional<double> number_in(const std::string& file) {
  std::ifstream stream(file);
  double value = 0;
  if (stream >> value) return value;
  return std::nullopt;
}

std::optional<double> number_in(const std::string& file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string word; stream >> word;) {
    double value = 0;
    if (word == key && stream >> value) return value;
    stream.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return std::nullopt;
}

}  // namespace raybundle::linalg
