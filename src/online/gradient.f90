! SPDX-License-Identifier: BSD-3-Clause
!> Derivatives of an answer with respect to the parameters, where closed contacts with a force stay closed and open ones stay open.
module sig_gradient
  use sig_answer, only: answer_t
  use sig_free_motions, only: anchor_work, free_motions
  use sig_friction_derivative, only: friction_derivative_t
  use sig_kinds, only: rk
  use sig_lcp_derivative, only: lcp_derivative_t
  use sig_lcp_rounding, only: small_forces
  use sig_rounding, only: dependent, rounding_of_data
  implicit none(type, external)
  private
  public :: gradient_t

  !> Derivatives: arrays have one column per parameter, per unit of the parameter.
  type :: gradient_t
    !> the answer whose derivatives these are: that of the model or, if the part that answered is not exact, perhaps the answer of
    !> the fallback at the same point (differentiate of sig_query)
    type(answer_t) :: answer
    !> +1: derivatives towards larger values of each parameter; -1: towards smaller values. Both differ where is_one_sided is true.
    integer :: direction = 1
    !> number of parameters that are the same at all times of a history; they come first
    integer :: n_given = 0
    !> [unit of each parameter] length of each parameter's range (lengths_at of sig_online_model), shape (n_parameters)
    real(rk), allocatable :: lengths(:)
    !> whether the derivative towards larger values differs from the one towards smaller values, shape (n_parameters)
    logical, allocatable :: is_one_sided(:)
    !> number of contacts that touch without a force
    integer :: n_grazing = 0
    !> derivatives of the terms, shape (n_terms, n_parameters)
    real(rk), allocatable :: theta(:, :)
    !> [force] derivatives of the unknowns of answer_t, shape (n_multipliers, n_parameters); in a tied part they are the derivatives
    !> of the forces of the changing rows, shape (n_changing, n_parameters)
    real(rk), allocatable :: unknowns(:, :)
    !> [force] derivatives of the multipliers, shape (n_multipliers, n_parameters)
    real(rk), allocatable :: multipliers(:, :)
    !> [length] derivatives of the distance by which each anchor closes (anchor_moves of sig_body_compliance), in an interpolated
    !> part only; shape (n_anchors, n_parameters)
    real(rk), allocatable :: moves(:, :)
    !> [length] derivatives of the coordinates of the modes, in an interpolated part only; shape (n_modes, n_parameters)
    real(rk), allocatable :: coordinates(:, :)
    !> [-] opening of each anchor in each motion that no contact force holds beside the point, as a parameter changes: such a motion
    !> has no derivative. Columns of zeros are no motions. Shape (n_anchors, n_anchors, n_parameters), in a condensed or
    !> interpolated part only
    real(rk), allocatable :: loose(:, :, :)
  contains
    procedure :: find_loose
    procedure :: is_loose
    procedure :: sizes
    procedure :: take
    procedure :: take_forces
    procedure :: take_step
  end type gradient_t

contains

  !> Returns the sizes of q for differentiate_lcp: `terms` plus, for each parameter, the absolute value of its change times the
  !> length of its range. So a load that is zero up to rounding, such as P - 0.3 at P = 0.3, closes no contact.
  pure function sizes(self, terms, changes)
    class(gradient_t), intent(in) :: self
    !> sum of the absolute values of the terms of q, shape (n_rows)
    real(rk), intent(in) :: terms(:)
    !> the change of W z + q for each parameter, per unit of it, shape (n_rows, n_parameters)
    real(rk), intent(in) :: changes(:, :)
    real(rk) :: sizes(size(terms))

    sizes = terms + matmul(abs(changes), self%lengths)
  end function sizes

  !> Sets the derivatives of the unknowns and n_grazing. is_one_sided becomes true for the parameters for which `derivative` is
  !> one-sided, and stays as it is for the others. Requires: direction and is_one_sided are set.
  pure subroutine take(self, derivative)
    class(gradient_t), intent(inout) :: self
    !> result of differentiate_lcp, a column per parameter, for changes that were multiplied by self%direction; self%unknowns are
    !> these derivatives times self%direction
    type(lcp_derivative_t), intent(in) :: derivative

    self%n_grazing = derivative%n_grazing
    self%is_one_sided = self%is_one_sided .or. derivative%is_one_sided
    self%unknowns = self%direction * derivative%unknowns
  end subroutine take

  !> Does the same as take, and sets the derivatives of the multipliers. These are the derivatives of the unknowns; for an anchor
  !> they are the derivatives of its complementary value divided by `scale`.
  pure subroutine take_forces(self, derivative, anchors, scale)
    class(gradient_t), intent(inout) :: self
    !> as for take
    type(lcp_derivative_t), intent(in) :: derivative
    !> rows that are anchors, 1-based among the multipliers
    integer, intent(in) :: anchors(:)
    !> [length/force] scale of the anchors' unknowns
    real(rk), intent(in) :: scale

    call self%take(derivative)
    self%multipliers = self%unknowns
    self%multipliers(anchors, :) = self%direction * derivative%openings(anchors, :) / scale
  end subroutine take_forces

  !> Does the same for a step of friction, whose unknowns are forces and motions.
  pure subroutine take_step(self, derivative, anchors)
    class(gradient_t), intent(inout) :: self
    !> result of differentiate_friction, as for take
    type(friction_derivative_t), intent(in) :: derivative
    !> rows that are anchors, 1-based; each has a motion
    integer, intent(in) :: anchors(:)

    self%n_grazing = derivative%n_grazing
    self%is_one_sided = self%is_one_sided .or. derivative%is_one_sided
    associate (n => size(derivative%forces, 1) - size(anchors), n_parameters => size(derivative%forces, 2))
      self%multipliers = self%direction * derivative%forces(:n, :)
      self%unknowns = self%multipliers
      self%unknowns(anchors, :) = self%direction * derivative%forces(n + 1:, :)
      if (allocated(self%loose)) deallocate (self%loose)
      allocate (self%loose(size(anchors), size(anchors), n_parameters), source=0.0_rk)
    end associate
  end subroutine take_step

  !> Finds the motions that neither the forces at the point nor those that arise beside it hold, for each parameter. Requires:
  !> take_forces.
  subroutine find_loose(self, matrix, anchors, scale, terms, unknowns, forces)
    class(gradient_t), intent(inout) :: self
    !> [length/force] W, shape (n_multipliers, n_multipliers)
    real(rk), intent(in) :: matrix(:, :)
    !> rows that are anchors, 1-based, and [length/force] their scale
    integer, intent(in) :: anchors(:)
    real(rk), intent(in) :: scale
    !> [length] result of `sizes`, shape (n_multipliers)
    real(rk), intent(in) :: terms(:)
    !> [force] z and forces at the point, shape (n_multipliers)
    real(rk), intent(in) :: unknowns(:)
    real(rk), intent(in) :: forces(:)
    real(rk), allocatable :: arising(:), motions(:, :), work(:, :)
    integer :: i

    if (allocated(self%loose)) deallocate (self%loose)
    allocate (self%loose(size(anchors), size(anchors), size(self%multipliers, 2)), source=0.0_rk)
    if (size(anchors) == 0) return
    work = anchor_work(matrix, anchors, scale)
    do i = 1, size(self%multipliers, 2)
      arising = self%direction * self%multipliers(:, i) * self%lengths(i)
      motions = free_motions(work, forces > 0 .or. (arising > 0 .and. .not. &
        small_forces(matrix, terms, anchors, scale, unknowns + abs(self%unknowns(:, i)) * self%lengths(i), arising, &
          rounding_of_data)))
      self%loose(:, :size(motions, 2), i) = motions
    end do
  end subroutine find_loose

  !> Whether a dof moves in one of the motions that no contact force holds as a parameter changes, so that its displacement has no
  !> derivative.
  pure logical function is_loose(self, i_parameter, motion)
    class(gradient_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: i_parameter
    !> [-] displacement of the dof as each anchor opens by 1, shape (n_anchors); the sign does not matter
    real(rk), intent(in) :: motion(:)

    is_loose = any(abs(matmul(motion, self%loose(:, :, i_parameter))) > dependent)
  end function is_loose
end module sig_gradient
