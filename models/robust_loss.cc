#include <raybundle/models/robust_loss.h>

#include <raybundle/models/error.h>

#include <algorithm>
#include <cmath>
#include <string>

// Each loss is written such that neither a tiny nor a huge s loses digits or overflows on the way.
namespace raybundle {
namespace {

struct None {
  explicit None(double) {}
  LossValue operator()(double s) const { return {s, 1}; }
};

struct Huber {
  explicit Huber(double scale) : c(scale) {}
  LossValue operator()(double s) const {
    const double root = std::sqrt(s);
    const bool inside = root <= c;
    return {inside ? s : c * (2 * root - c), inside ? 1 : c / root};
  }
  double c;
};

struct SoftL1 {
  explicit SoftL1(double scale) : c(scale) {}
  LossValue operator()(double s) const {
    const double root = std::sqrt(c * c + s);
    return {s * (2 * c / (c + root)), c / root};
  }
  double c;
};

struct Cauchy {
  explicit Cauchy(double scale) : c2(scale * scale) {}
  LossValue operator()(double s) const { return {c2 * std::log1p(s / c2), c2 / (c2 + s)}; }
  double c2;
};

struct GemanMcClure {
  explicit GemanMcClure(double scale) : c2(scale * scale) {}
  LossValue operator()(double s) const {
    const double q = c2 / (c2 + s);
    return {s * q, q * q};
  }
  double c2;
};

struct Tukey {
  explicit Tukey(double scale) : c2(scale * scale) {}
  LossValue operator()(double s) const {
    const double x = s / c2;
    const bool inside = x < 1;
    return {inside ? s * (1 - x + x * x / 3) : c2 / 3, inside ? (1 - x) * (1 - x) : 0};
  }
  double c2;
};

struct Truncated {
  explicit Truncated(double scale) : c2(scale * scale) {}
  LossValue operator()(double s) const {
    const bool inside = s <= c2;
    return {inside ? s : c2, inside ? 1.0 : 0.0};
  }
  double c2;
};

/// 0 s is 0, but NaN where s is not finite.
template <class Function>
LossValue guarded(const Function& function, double s) {
  const LossValue value = function(s);
  return {value.rho + 0 * s, value.weight + 0 * s};
}

/// use(function) with the loss as a function object, so that loops over s choose it once.
template <class Use>
auto with_function(const RobustLoss& loss, const Use& use) {
  switch (loss.kind) {
    case Loss::none:
      break;
    case Loss::huber:
      return use(Huber(loss.scale));
    case Loss::soft_l1:
      return use(SoftL1(loss.scale));
    case Loss::cauchy:
      return use(Cauchy(loss.scale));
    case Loss::geman_mcclure:
      return use(GemanMcClure(loss.scale));
    case Loss::tukey:
      return use(Tukey(loss.scale));
    case Loss::truncated:
      return use(Truncated(loss.scale));
  }
  return use(None(loss.scale));
}

/// sum rho over all rows; `keep(first row, count, weights)` gets what applies to whole rows. Some
/// rows at a time go through loops that do one thing each, so that the compiler can do several rows
/// at once.
template <class Keep>
double sum(const RobustLoss& loss, const double* residual, std::int64_t rows, int size,
           const Keep& keep) {
  return with_function(loss, [&](const auto& function) {
    constexpr std::int64_t most = 64;
    double s[most], rho[most], weight[most];
    double total = 0;
    for (std::int64_t first = 0; first < rows; first += most) {
      const std::int64_t count = std::min(most, rows - first);
      const double* r = residual + size * first;
      for (std::int64_t i = 0; i < count; ++i) s[i] = r[size * i] * r[size * i];
      for (int k = 1; k < size; ++k) {
        for (std::int64_t i = 0; i < count; ++i) s[i] += r[size * i + k] * r[size * i + k];
      }
      for (std::int64_t i = 0; i < count; ++i) {
        const LossValue value = guarded(function, s[i]);
        rho[i] = value.rho;
        weight[i] = value.weight;
      }
      for (std::int64_t i = 0; i < count; ++i) total += rho[i];
      keep(first, count, weight);
    }
    return total;
  });
}

/// Residuals as the loss takes them: of several components, or each by itself.
struct Scope {
  Scope(const RobustLoss& loss, std::int64_t all_rows, int row_size)
      : rows(loss.scope == LossScope::component ? row_size * all_rows : all_rows),
        size(loss.scope == LossScope::component ? 1 : row_size) {}
  std::int64_t rows;
  int size;
};

template <int width>
void scale_rows_of(const double* factor, std::int64_t rows, double* values) {
  for (std::int64_t row = 0; row < rows; ++row) {
    const double f = factor[row];
    double* first = values + row * width;
    // 0 times an infinite derivative would be NaN.
    for (int k = 0; k < width; ++k) first[k] = f == 0 ? 0 : f * first[k];
  }
}

}  // namespace

bool levels_off(Loss loss) {
  return loss == Loss::geman_mcclure || loss == Loss::tukey || loss == Loss::truncated;
}

double default_scale(Loss loss) {
  switch (loss) {
    case Loss::geman_mcclure:
    case Loss::truncated:
      return 3;
    case Loss::tukey:
      return 6;
    default:
      return 1;
  }
}

void validate(const RobustLoss& loss) {
  if (loss.scale >= 1e-100 && loss.scale <= 1e100) return;
  throw InputError("loss", 0, "a scale of " + std::to_string(loss.scale) + " pixels",
                   "a number from 1e-100 to 1e100");
}

LossValue evaluate(const RobustLoss& loss, double s) {
  return with_function(loss, [s](const auto& function) { return guarded(function, s); });
}

double robust_sum(const RobustLoss& loss, const double* residual, std::int64_t rows, int size) {
  const Scope scope(loss, rows, size);
  return sum(loss, residual, scope.rows, scope.size,
             [](std::int64_t, std::int64_t, const double*) {});
}

double robust_weights(const RobustLoss& loss, const double* residual, std::int64_t rows, int size,
                      double* root_weight) {
  const Scope scope(loss, rows, size);
  return sum(loss, residual, scope.rows, scope.size,
             [&](std::int64_t first, std::int64_t count, double* weight) {
               for (std::int64_t i = 0; i < count; ++i) weight[i] = std::sqrt(weight[i]);
               double* root = root_weight + scope.size * first;
               for (int k = 0; k < scope.size; ++k) {
                 for (std::int64_t i = 0; i < count; ++i) root[scope.size * i + k] = weight[i];
               }
             });
}

void scale_rows(const double* factor, std::int64_t rows, int width, double* values) {
  switch (width) {
    case 3:
      return scale_rows_of<3>(factor, rows, values);
    case 6:
      return scale_rows_of<6>(factor, rows, values);
    case 9:
      return scale_rows_of<9>(factor, rows, values);
    default:
      for (std::int64_t i = 0; i < width * rows; ++i) {
        scale_rows_of<1>(factor + i / width, 1, values + i);
      }
  }
}

}  // namespace raybundle
