! SPDX-License-Identifier: BSD-3-Clause
!> Which of two solutions of a reduced problem is nearer to the full-order one: that with the smaller energy of its forces.
!>
!> (10) may have several solutions, because its matrix is neither symmetric nor a P-matrix. The full-order forces are the minimum of
!> E(lambda) = 1/2 lambda' W lambda + q' lambda over lambda >= 0, W and q those of all contacts, and
!> E(lambda_r) - E(lambda) = 1/2 |lambda_r - lambda|^2 in the norm of W + lambda_r' w(lambda), which is not negative.
module sig_solution_choice
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_solution_t
  use sig_linear_algebra, only: multiply
  use sig_multiplier_fit, only: multiplier_fit_workspace_t
  use sig_online_model, only: online_model_t
  implicit none(type, external)
  private
  public :: solution_choice_t

  !> Room of one thread.
  type :: solution_choice_t
    private
    type(multiplier_fit_workspace_t) :: fit
    !> [length] gamma of a solution, shape (n_modes)
    real(rk), allocatable :: coordinates(:)
    !> [force] of all contacts, and [length] q, then W lambda / 2 + q; shape (n_multipliers)
    real(rk), allocatable :: multipliers(:)
    real(rk), allocatable :: opening(:)
  contains
    procedure :: is_other_better
    procedure, private :: force_energy
  end type solution_choice_t

contains

  !> The other solution has the smaller energy.
  !>
  !> Requires: the model has the full-order multipliers.
  logical function is_other_better(self, online, cluster, theta, free_coordinates, solution, other)
    class(solution_choice_t), intent(inout) :: self
    !> prepared
    type(online_model_t), intent(in) :: online
    integer, intent(in) :: cluster
    !> values of the model's terms, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] gamma without contact forces, shape (n_modes)
    real(rk), contiguous, intent(in) :: free_coordinates(:)
    type(lcp_solution_t), intent(in) :: solution
    type(lcp_solution_t), intent(in) :: other
    real(rk) :: energy

    energy = self%force_energy(online, cluster, theta, free_coordinates, solution)
    is_other_better = self%force_energy(online, cluster, theta, free_coordinates, other) < energy
  end function is_other_better

  !> [force*length] E of the forces of all contacts, those outside of the domain reconstructed.
  real(rk) function force_energy(self, online, cluster, theta, free_coordinates, solution) result(energy)
    class(solution_choice_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    integer, intent(in) :: cluster
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: free_coordinates(:)
    type(lcp_solution_t), intent(in) :: solution

    if (.not. allocated(self%multipliers)) allocate (self%multipliers(online%model%n_multipliers), &
      self%opening(online%model%n_multipliers), self%coordinates(maxval(online%systems%n_modes)))
    associate (system => online%systems(cluster), coordinates => self%coordinates(:size(free_coordinates)), &
      full_order => online%model%full_order)
      coordinates = free_coordinates
      call multiply(-1.0_rk, system%multiplier_response, solution%lambda, 1.0_rk, coordinates)
      call online%fits(cluster)%evaluate(online%model%clusters(cluster), theta, coordinates, solution%lambda, self%fit, &
        self%multipliers)
      call multiply(1.0_rk, full_order%free_opening, theta, 0.0_rk, self%opening)
      call multiply(0.5_rk, full_order%compliance, self%multipliers, 1.0_rk, self%opening)
    end associate
    energy = dot_product(self%multipliers, self%opening)
  end function force_energy
end module sig_solution_choice
