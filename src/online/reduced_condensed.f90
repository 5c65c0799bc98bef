! SPDX-License-Identifier: BSD-3-Clause
!> The full-order contact problem condensed to its contacts, as a kind of reduced model. It is exact on all contacts and needs no
!> mesh.
!>
!> A query starts from the active set of the nearest training point. If this point has a reference with a principal pivot transform,
!> the transformed problem is solved: its unknowns are zero except for the contacts whose status differs from the reference.
module sig_reduced_condensed
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_condensed, answer_t, comparable_size
  use sig_bits, only: unpack_bits
  use sig_condensed_certificate, only: condensed_certificate_t
  use sig_condensed_data, only: condensed_data_t
  use sig_condensed_displacement, only: condensed_anchor_motion, condensed_displacement_of_dof, fill_condensed_displacement
  use sig_description_line, only: line
  use sig_gradient, only: gradient_t
  use sig_kinds, only: rk
  use sig_lcp_derivative, only: differentiate_lcp, lcp_derivative_t
  use sig_lcp, only: change_sets, lcp_solution_t, lcp_workspace_t, solve_lcp
  use sig_lcp_rounding, only: drop_rounding, lcp_sizes_t
  use sig_linear_algebra, only: multiply
  use sig_pivot_transform, only: transform_columns
  use sig_reasons, only: reason_pulled_off, reason_ray
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_reduced_exact, only: count_free, displacement_text, not_unique, pushed, round_work, take_forces
  use sig_rounding, only: rounding
  use sig_text, only: counted
  implicit none(type, external)
  private
  public :: reduced_condensed_t

  type, extends(condensed_data_t) :: reduced_condensed_t
    !> [force per unit of theta] q / transform_scale of each transform; shape (n_multipliers, n_terms, n_references)
    real(rk), allocatable, private :: transformed_opening(:, :, :)
    !> of W and q
    type(lcp_sizes_t), private :: sizes
    !> active sets of the references, shape (n_multipliers, n_references)
    logical, allocatable, private :: reference_sets(:, :)
    type(condensed_certificate_t), allocatable, private :: certificate
  contains
    procedure :: kind => kind_of
    procedure :: prepare
    procedure :: transform_openings
    procedure :: create_room
    procedure :: solve
    procedure :: fill_displacement
    procedure :: displacement_of_dof
    procedure :: describe
    procedure :: energy
    procedure :: correct_forces
    procedure :: can_certify
    procedure :: certify
    procedure :: differentiate
    procedure :: displacement_changes
  end type reduced_condensed_t

  type, extends(room_t) :: condensed_room_t
    type(lcp_workspace_t) :: workspace
    type(lcp_solution_t) :: solution
    !> [length] openings without contact forces and with them, shape (n_multipliers)
    real(rk), allocatable :: free_opening(:)
    real(rk), allocatable :: opening(:)
    !> [force] q of the transformed problem, shape (n_multipliers)
    real(rk), allocatable :: transformed(:)
    !> active set to start from; in solve_transformed for a while its difference to the reference; shape (n_multipliers)
    logical, allocatable :: start(:)
  end type condensed_room_t

contains

  pure function kind_of(self) result(name)
    class(reduced_condensed_t), intent(in) :: self
    character(:), allocatable :: name

    name = 'condensed'
  end function kind_of

  !> Measures W and q, transforms the columns of free_opening for each reference, and factors W without the anchors, for bounds
  !> (can_certify says whether this succeeds). There are no errors: message stays unallocated.
  subroutine prepare(self, message)
    class(reduced_condensed_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message
    type(condensed_certificate_t), allocatable :: certificate

    call self%transform_openings()
    allocate (certificate)
    call certificate%create(self)
    call move_alloc(certificate, self%certificate)
  end subroutine prepare

  !> Measures W and q, and transforms the columns of free_opening for each reference: `solve` needs both.
  subroutine transform_openings(self)
    class(reduced_condensed_t), intent(inout) :: self
    integer :: i, n
    real(rk) :: scale

    call self%sizes%create(self%compliance, self%free_opening)
    scale = self%transform_scale()
    n = size(self%compliance, 1)
    if (allocated(self%transformed_opening)) deallocate (self%transformed_opening, self%reference_sets)
    associate (points => self%reference_points)
      allocate (self%transformed_opening(n, size(self%free_opening, 2), size(points)), self%reference_sets(n, size(points)))
      do i = 1, size(points)
        call unpack_bits(self%start_sets(:, points(i)), self%reference_sets(:, i))
        self%transformed_opening(:, :, i) = self%free_opening / scale
        call transform_columns(self%transforms(:, (i - 1) * n + 1:i * n), self%reference_sets(:, i), &
          self%transformed_opening(:, :, i))
      end do
    end associate
  end subroutine transform_openings

  !> Makes the work arrays for one thread.
  subroutine create_room(self, room)
    class(reduced_condensed_t), intent(in) :: self
    class(room_t), allocatable, intent(out) :: room
    type(condensed_room_t), allocatable :: own
    integer :: n

    n = size(self%compliance, 1)
    allocate (own)
    allocate (own%free_opening(n), own%opening(n), own%transformed(n), own%start(n))
    call move_alloc(own, room)
  end subroutine create_room

  !> Solves the complementarity problem of all contacts: by the pivot transform of the nearest training point's reference, if there
  !> is one, and with all of W if that gives no answer. Without an answer the reason is that of solve_lcp; in a problem with anchors
  !> reason_ray becomes reason_pulled_off. The arguments are those of solve_at in sig_reduced; `judge` is not used.
  subroutine solve(self, theta, near, judge, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    class(reduced_t), pointer, intent(in) :: judge
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    select type (room)
    type is (condensed_room_t)
      call self%open_freely(theta, room%free_opening)
      answer%n_iterations = 0
      call start_set(self, near, room)
      answer%reason = reason_ray
      if (near%nearest >= 1 .and. near%nearest <= size(self%reference_of_point)) &
        call solve_transformed(self, self%reference_of_point(near%nearest), theta, room, answer)
      if (answer%reason < 0) call solve_whole(self, room, answer)
      if (answer%reason == reason_ray .and. size(self%anchors) > 0) answer%reason = reason_pulled_off
      if (answer%reason <= 0) return
      call take_forces(self%compliance, room%free_opening, self%anchors, self%scale, room%opening, answer)
      call drop_rounding(self%sizes, self%compliance, self%free_opening, theta, self%anchors, self%scale, answer%unknowns, &
        answer%multipliers)
      call count_free(self%compliance, self%anchors, self%scale, answer)
      call answer%take_all_forces()
    end select
  end subroutine solve

  !> Sets room%start, the active set to start from: true for each row whose unknown is taken as positive, which means a contact with
  !> a force, or an anchor that is open. It is the set of the nearest training point. If this part has no such set, room%start is
  !> true for rows that penetrate without contact forces or, in a problem with anchors, for all rows but the anchors. Requires:
  !> room%free_opening is set.
  subroutine start_set(data, near, room)
    class(condensed_data_t), intent(in) :: data
    type(neighbors_t), intent(in) :: near
    type(condensed_room_t), intent(inout) :: room

    if (near%nearest >= 1 .and. near%nearest <= size(data%start_sets, 2)) then
      call unpack_bits(data%start_sets(:, near%nearest), room%start)
    else if (size(data%anchors) == 0) then
      room%start = room%free_opening < 0
    else
      room%start = .true.
      room%start(data%anchors) = .false.
    end if
  end subroutine start_set

  !> Solves the problem by the pivot transform of a reference and the active set method alone (change_sets), from the active set in
  !> room%start. Only contacts whose status differs from the reference cost work. If answer%reason > 0, answer%unknowns become the
  !> unknowns of the problem before the transform; otherwise they do not change.
  subroutine solve_transformed(self, i_reference, theta, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    !> number of the reference, 1-based
    integer, intent(in) :: i_reference
    real(rk), contiguous, intent(in) :: theta(:)
    type(condensed_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    integer :: i, n

    n = size(room%opening)
    call multiply(1.0_rk, self%transformed_opening(:, :, i_reference), theta, 0.0_rk, room%transformed)
    associate (in_reference => self%reference_sets(:, i_reference))
      room%start = room%start .neqv. in_reference
      call change_sets(self%transforms(:, (i_reference - 1) * n + 1:i_reference * n), room%transformed, room%start, &
        room%solution, room%workspace)
      room%start = room%start .neqv. in_reference
      call answer%take_solution(room%solution, answer_condensed)
      if (answer%reason < 0) return
      do i = 1, n
        answer%unknowns(i) = room%solution%lambda(i)
        if (in_reference(i)) answer%unknowns(i) = merge(0.0_rk, max(0.0_rk, room%workspace%w(i)), room%solution%lambda(i) > 0)
      end do
    end associate
  end subroutine solve_transformed

  !> Solves the problem with all of W by solve_lcp, from the active set in room%start. Without an answer answer%unknowns are zero.
  subroutine solve_whole(self, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    type(condensed_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    call solve_lcp(self%compliance, room%free_opening, room%start, room%solution, room%workspace)
    call answer%take_solution(room%solution, answer_condensed)
    answer%unknowns = room%solution%lambda
  end subroutine solve_whole

  !> Computes the displacement [length] of all dofs, shape (n_dofs); it is NaN for dofs of which this part has none.
  subroutine fill_displacement(self, answer, displacement)
    class(reduced_condensed_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    call fill_condensed_displacement(self, answer%theta, answer%unknowns, displacement)
  end subroutine fill_displacement

  !> Returns the displacement [length] of one dof, 1-based; NaN if this part has none of this dof.
  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(reduced_condensed_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    displacement = condensed_displacement_of_dof(self, answer%theta, answer%unknowns, dof)
  end function displacement_of_dof

  !> Returns lines about forces, displacements and pivot transforms of the part, each with its line end.
  pure function describe(self) result(text)
    class(reduced_condensed_t), intent(in) :: self
    character(:), allocatable :: text

    text = line('  forces', 'exact on all ' // counted(self%n_rows(), 'contact row'))
    text = text // line('  displacements', displacement_text(self%exact_boundaries, size(self%exact_dofs), self%field%describe()))
    text = text // line('  pivot transforms', counted(size(self%reference_points), 'reference set'))
  end function describe

  !> Returns the energy E = 1/2 lambda' W lambda + q' lambda [force*length] of forces of all contacts, without the rows of anchors;
  !> huge for forces that do not balance the loads on bodies that only contact holds. Arguments: energy_unknown in sig_reduced.
  !> Requires: prepare.
  real(rk) function energy(self, theta, multipliers, opening)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: multipliers(:)
    real(rk), contiguous, intent(inout) :: opening(:)

    energy = self%certificate%energy(self, theta, multipliers, opening)
  end function energy

  !> If only contact holds a body, removes forces on open contacts from `multipliers` and balances the others (correct of
  !> sig_condensed_certificate, which says when nothing changes). Otherwise it does nothing. Arguments: nothing_to_correct in
  !> sig_reduced. Requires: prepare.
  subroutine correct_forces(self, theta, room, multipliers)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    class(room_t), intent(inout) :: room
    real(rk), contiguous, intent(inout) :: multipliers(:)

    select type (room)
    type is (condensed_room_t)
      call self%certificate%correct(self, theta, room%free_opening, room%opening, multipliers)
    end select
  end subroutine correct_forces

  !> Whether the part can bound errors: W without the rows of the anchors is positive definite.
  pure logical function can_certify(self)
    class(reduced_condensed_t), intent(in) :: self

    can_certify = .false.
    if (allocated(self%certificate)) can_certify = self%certificate%is_valid()
  end function can_certify

  !> Sets bound and relative_bound of the answer: bounds of the error of `multipliers`, whichever part found them, and for own
  !> forces those of the displacement
  !> (sig_condensed_certificate). Both are huge for forces of another part that do not balance the loads on bodies that only contact
  !> holds. Arguments: no_certificate in sig_reduced. Requires: can_certify; for own forces, that solve with this room found them
  !> last.
  subroutine certify(self, multipliers, is_own, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: multipliers(:)
    logical, intent(in) :: is_own
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    select type (room)
    type is (condensed_room_t)
      call self%certificate%certify(self, multipliers, is_own, room%free_opening, room%opening, answer)
      if (is_own .and. self%has_displacement()) call certify_displacement(self, room, answer)
    end select
  end subroutine certify

  !> Sets displacement_bound and relative_displacement_bound: the error of the forces in the norm of W, which is that of the
  !> displacement in the norm of the stiffness, and that of H z (sig_contact_field). Rigid motions do not count.
  subroutine certify_displacement(self, room, answer)
    class(reduced_condensed_t), intent(in) :: self
    !> after certify for own forces
    type(condensed_room_t), intent(in) :: room
    type(answer_t), intent(inout) :: answer
    real(rk) :: energy, size_of_field

    ! openings of anchors do not count in z'W z, as their rows and columns of W have opposite signs
    energy = max(0.0_rk, dot_product(answer%unknowns, room%opening - room%free_opening))
    size_of_field = comparable_size(self%size_of_field(answer%theta, answer%unknowns, energy), self%largest_field)
    call answer%take_displacement_bound(answer%bound + rounding * size_of_field + &
      self%field%error_of(answer%unknowns, energy), size_of_field)
  end subroutine certify_displacement

  !> Computes the derivatives of the unknowns and of the multipliers with respect to each parameter. Errors: message is allocated if
  !> the contact forces are not unique, the loads move a body that no contact force holds, or the problem of the contacts that graze
  !> has no solution (differentiate_lcp). Arguments: no_derivative in sig_reduced.
  subroutine differentiate(self, answer, gradient, message)
    class(reduced_condensed_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    real(rk) :: free_opening(self%n_rows()), terms(self%n_rows())
    real(rk), allocatable :: changes(:, :)
    type(lcp_derivative_t) :: derivative

    call self%open_freely(answer%theta, free_opening)
    terms = matmul(abs(self%free_opening), abs(answer%theta))
    changes = gradient%direction * matmul(self%free_opening, gradient%theta)
    call round_work(self%anchors, matmul(abs(self%free_opening(self%anchors, :)), abs(gradient%theta)), changes)
    call differentiate_lcp(self%compliance, free_opening, gradient%sizes(terms, changes), answer%unknowns, changes, derivative, &
      self%anchors)
    if (derivative%is_pushed) then
      message = pushed
    else if (derivative%is_singular) then
      message = not_unique
    else
      call gradient%take_forces(derivative, self%anchors, self%scale)
      call gradient%find_loose(self%compliance, self%anchors, self%scale, gradient%sizes(terms, changes), answer%unknowns, &
        answer%multipliers)
    end if
  end subroutine differentiate

  !> Computes the derivatives of the displacement of the given dofs with respect to one parameter; NaN for dofs of which this part
  !> has no displacement, and for those that move in a motion that no contact force holds. The displacement is linear in the terms
  !> and in the unknowns. Arguments: no_changes in sig_reduced.
  subroutine displacement_changes(self, answer, gradient, i_parameter, dofs, changes)
    class(reduced_condensed_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    type(gradient_t), intent(in) :: gradient
    integer, intent(in) :: i_parameter
    integer, intent(in) :: dofs(:)
    real(rk), intent(out) :: changes(:)
    real(rk), allocatable :: field(:)
    integer :: i

    associate (theta => gradient%theta(:, i_parameter), unknowns => gradient%unknowns(:, i_parameter))
      if (self%field%is_there() .and. size(dofs) > 1) then
        ! a row of compressed responses costs a search
        allocate (field(size(self%field%motions, 1)))
        call fill_condensed_displacement(self, theta, unknowns, field)
        changes = field(dofs)
      else
        changes = [(condensed_displacement_of_dof(self, theta, unknowns, dofs(i)), i=1, size(dofs))]
      end if
    end associate
    do i = 1, size(dofs)
      if (gradient%is_loose(i_parameter, condensed_anchor_motion(self, dofs(i)))) changes(i) = ieee_value(1.0_rk, ieee_quiet_nan)
    end do
  end subroutine displacement_changes
end module sig_reduced_condensed
