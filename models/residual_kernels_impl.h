// The kernels of residual_kernels.h for one instruction set; see linalg/kernels.

#include <raybundle/models/bal_lens.h>
#include <raybundle/models/residual_kernels.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

using Index = std::int64_t;

// X_c = R_cw X + t_cw  [Qu18, Eq. 3.5].
inline void to_camera(const CameraFrame& camera, const double* X, double* X_c) {
  for (int i = 0; i < 3; ++i) {
    const double* R = camera.R_cw + 3 * i;
    X_c[i] = R[0] * X[0] + R[1] * X[1] + R[2] * X[2] + camera.t_cw[i];
  }
}

// out^T = a^T B for a 3x3 B.
inline void row_times_matrix(const double* a, const double* B, double* out) {
  for (int j = 0; j < 3; ++j) out[j] = a[0] * B[j] + a[1] * B[3 + j] + a[2] * B[6 + j];
}

inline void cross(const double* a, const double* b, double* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

inline void residual_of(const ResidualInput& in, Index row, double* residual) {
  const CameraFrame& camera = in.cameras[in.row_camera[row]];
  double X_c[3], u[2];
  to_camera(camera, in.points + 3 * Index{in.row_point[row]}, X_c);
  bal_lens::project(camera.lens, X_c, u);
  for (int i = 0; i < 2; ++i) residual[i] = u[i] - in.observed[2 * row + i];
}

double cost(const ResidualInput& in, Index first, Index last) {
  double sum = 0;
  for (Index row = first; row < last; ++row) {
    double d[2];
    residual_of(in, row, d);
    sum += d[0] * d[0] + d[1] * d[1];
  }
  return 0.5 * sum;
}

void residuals(const ResidualInput& in, double* residual, Index first, Index last) {
  for (Index row = first; row < last; ++row) residual_of(in, row, residual + 2 * (row - first));
}

// The derivative of one residual by the pose, with a = its gradient by X_c and b = by the point.
template <PoseUpdate Update>
inline void pose_row(const CameraFrame& camera, const double* X, const double* X_c, const double* a,
                     const double* b, double* J) {
  if constexpr (Update == PoseUpdate::local) {
    // -R hat(X) and R  [Qu18, Eq. 4.19, 4.16]
    cross(X, b, J);
    for (int i = 0; i < 3; ++i) J[3 + i] = b[i];
  } else if constexpr (Update == PoseUpdate::global) {
    // -R hat(X) J_r and I  [Qu18, Eq. 3.27, 3.18]
    double w[3];
    cross(X, b, w);
    row_times_matrix(w, camera.J_r, J);
    for (int i = 0; i < 3; ++i) J[3 + i] = a[i];
  } else {
    // d(Exp(phi) X_c + t) at 0: -hat(X_c) and I
    cross(X_c, a, J);
    for (int i = 0; i < 3; ++i) J[3 + i] = a[i];
  }
}

template <PoseUpdate Update, Lens LensUse>
double linearize(const ResidualInput& in, const ResidualOutput& out, Index first, Index last) {
  constexpr int hub_size = LensUse == Lens::free ? 9 : 6;
  double sum = 0;
  for (Index row = first; row < last; ++row) {
    const CameraFrame& camera = in.cameras[in.row_camera[row]];
    const double* X = in.points + 3 * Index{in.row_point[row]};
    double X_c[3], u[2], A[6], L[6];
    to_camera(camera, X, X_c);
    bal_lens::project(camera.lens, X_c, u, A, L);
    for (int i = 0; i < 2; ++i) {
      const double residual = u[i] - in.observed[2 * row + i];
      sum += residual * residual;
      out.residual[2 * row + i] = residual;
      double* J_leaf = out.J_leaf + (2 * row + i) * 3;
      double* J_hub = out.J_hub + (2 * row + i) * hub_size;
      row_times_matrix(A + 3 * i, camera.R_cw, J_leaf);  // [Qu18, Eq. 3.37]
      pose_row<Update>(camera, X, X_c, A + 3 * i, J_leaf, J_hub);
      if constexpr (LensUse == Lens::free) {
        for (int k = 0; k < 3; ++k) J_hub[6 + k] = L[3 * i + k];
      }
    }
  }
  return 0.5 * sum;
}

template <PoseUpdate Update, Lens LensUse>
constexpr ResidualKernels kernels_for = {&cost, &residuals, &linearize<Update, LensUse>};

}  // namespace

// Indexed by PoseUpdate and Lens, in the order of their values.
extern const ResidualKernels residual_kernel_table[3][2] = {
    {kernels_for<PoseUpdate::global, Lens::free>, kernels_for<PoseUpdate::global, Lens::fixed>},
    {kernels_for<PoseUpdate::local, Lens::free>, kernels_for<PoseUpdate::local, Lens::fixed>},
    {kernels_for<PoseUpdate::se3, Lens::free>, kernels_for<PoseUpdate::se3, Lens::fixed>}};

}  // namespace raybundle::RAYBUNDLE_ISA
