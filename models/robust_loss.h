#pragma once

#include <cstdint>

/// Robust losses: what an observation far off costs less than its square [Qu18, 4.3].
namespace raybundle {

/// rho(s) of a squared residual s, with scale c; all have rho(0) = 0, rho'(0) = 1 and are concave:
///   none           s
///   huber          s up to c^2, then 2 c sqrt(s) - c^2                          [Qu18, Eq. 4.21]
///   soft_l1        2 c^2 (sqrt(1 + s/c^2) - 1)
///   cauchy         c^2 log(1 + s/c^2)
///   geman_mcclure  s / (1 + s/c^2)
///   tukey          c^2/3 (1 - (1 - s/c^2)^3) up to c^2, then constant           (biweight)
///   truncated      min(s, c^2)                                                  [Qu18, Eq. 4.22]
enum class Loss { none, huber, soft_l1, cauchy, geman_mcclure, tukey, truncated };

/// What s is: |r|^2 of an observation, or the square of each of its components, as
/// [Qu18, Eq. 4.20] has it.
enum class LossScope { observation, component };

struct RobustLoss {
  Loss kind = Loss::none;
  LossScope scope = LossScope::observation;
  double scale = 1;  ///< c, pixels
};

/// What noise of one pixel asks for: 1, but where a loss levels off what keeps about 99 of 100
/// normal errors: 3 for geman_mcclure and truncated, 6 for tukey, which weighs 9/16 at half of it.
double default_scale(Loss loss);

/// Whether it is bounded: far off, an observation pulls at nothing.
bool levels_off(Loss loss);

/// Throws InputError unless the scale is from 1e-100 to 1e100.
void validate(const RobustLoss& loss);

struct LossValue {
  double rho;
  double weight;  ///< rho'(s): Psi'(|F|)/|F| for rho = 2 Psi  [Qu18, Eq. 4.23]
};

/// For s >= 0. Not finite where s is not, whatever the loss: an observation that cannot be
/// projected is not an outlier.
LossValue evaluate(const RobustLoss& loss, double s);

/// sum rho over `rows` residuals of `size` components each.
double robust_sum(const RobustLoss& loss, const double* residual, std::int64_t rows, int size = 2);

/// The same; sqrt(weight) of every component goes to `root_weight` (size x rows).
double robust_weights(const RobustLoss& loss, const double* residual, std::int64_t rows, int size,
                      double* root_weight);

/// Multiplies rows of `width` numbers by one factor each; a factor of 0 gives 0, whatever stood
/// there.
void scale_rows(const double* factor, std::int64_t rows, int width, double* values);

}  // namespace raybundle
