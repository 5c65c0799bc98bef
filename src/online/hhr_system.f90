! SPDX-License-Identifier: BSD-3-Clause
!> The equations (10) of a hyper-reduced model condensed on the multipliers of its domain.
module sig_hhr_system
  use sig_hhr_data, only: hhr_data_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: lu_t, multiply
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: hhr_system_t

  type :: hhr_system_t
    !> W = M K_r^-1 M', shape (n_rows, n_rows)
    real(rk), allocatable :: condensed(:, :)
    !> (q, K_r^-1 F) = response theta with q = D - M K_r^-1 F, shape (n_rows + n_modes, n_terms)
    real(rk), allocatable :: response(:, :)
    !> gamma = K_r^-1 F - multiplier_response lambda, shape (n_modes, n_rows)
    real(rk), allocatable :: multiplier_response(:, :)
  contains
    procedure :: create
    procedure :: coordinates
  end type hhr_system_t

contains

  !> Errors: message is allocated when the reduced stiffness is numerically singular.
  subroutine create(self, cluster, message)
    class(hhr_system_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster
    character(:), allocatable, intent(out) :: message
    type(lu_t) :: lu

    call lu%factor(cluster%reduced_stiffness)
    if (lu%is_singular) then
      message = 'the reduced stiffness (' // to_text(cluster%n_modes) // ' modes) is numerically singular: its reciprocal ' &
        // 'condition number is ' // to_text(lu%reciprocal_condition) // '; the equations of the reduced integration domain ' &
        // 'do not determine every mode (a larger pod_tolerance or a zone of interest mends that)'
      return
    end if
    self%multiplier_response = lu%solve(transpose(cluster%contact_matrix))
    self%condensed = matmul(cluster%contact_matrix, self%multiplier_response)
    if (allocated(self%response)) deallocate (self%response)
    allocate (self%response(cluster%n_rows + cluster%n_modes, size(cluster%load, 2)))
    self%response(cluster%n_rows + 1:, :) = lu%solve(cluster%load)
    self%response(:cluster%n_rows, :) = cluster%gap - matmul(cluster%contact_matrix, self%response(cluster%n_rows + 1:, :))
  end subroutine create

  !> gamma under the forces of the domain.
  subroutine coordinates(self, response, multipliers, values)
    class(hhr_system_t), intent(in) :: self
    !> response theta, shape (n_rows + n_modes)
    real(rk), intent(in) :: response(:)
    !> [force] shape (n_rows)
    real(rk), contiguous, intent(in) :: multipliers(:)
    !> [length] shape (n_modes)
    real(rk), contiguous, intent(inout) :: values(:)

    values = response(size(multipliers) + 1:)
    call multiply(-1.0_rk, self%multiplier_response, multipliers, 1.0_rk, values)
  end subroutine coordinates
end module sig_hhr_system
