! SPDX-License-Identifier: BSD-3-Clause
!> The answer of a model at a parameter point, and its texts for tables and reports.
module sig_answer
  use sig_kinds, only: rk
  use sig_lcp, only: lcp_lemke, lcp_method_name, lcp_solution_t
  use sig_reasons, only: reason_bad_point
  use sig_text, only: csv_number
  implicit none(type, external)
  private
  public :: answer_t, bound_text, comparable_size, method_name

  !> method of an answer by the condensed full-order problem; the other methods are those of sig_lcp
  integer, parameter, public :: answer_condensed = lcp_lemke + 1
  integer, parameter, public :: n_answer_methods = answer_condensed

  !> value of a bound that the model cannot give
  real(rk), parameter, public :: no_bound = -1

  !> Answer at one point. Without an answer (reason <= 0) the arrays have no meaning.
  type :: answer_t
    !> part that was asked first, 1-based: the cluster that the choice or the caller selected; in an answer that only derivatives
    !> need, it may be the fallback
    integer :: cluster = 1
    !> part that answered: the cluster, or the model's fallback
    integer :: part = 1
    !> part that gives the displacement
    integer :: displacement_part = 1
    !> cluster of contacts that answered, in a part of the kind tied; 0 = none
    integer :: row_cluster = 0
    !> [length] gamma of the cluster, shape (n_modes)
    real(rk), allocatable :: coordinates(:)
    !> [force] lambda on the contact rows of the cluster, shape (n_rows)
    real(rk), allocatable :: multipliers_rid(:)
    !> whether lambda > 0 on the contact rows of the cluster, shape (n_rows)
    logical, allocatable :: is_active(:)
    !> [force] lambda on all contacts, shape (n_multipliers); not known if is_whole is false
    real(rk), allocatable :: multipliers(:)
    logical :: is_whole = .false.
    !> [force] z, the unknowns of the solved problem, shape (n_multipliers): contact forces; at anchors the openings over the
    !> `scale` of the part. In a part of the kind tied those of the changing rows come first. Zero if a part of the kind hhr
    !> answered
    real(rk), allocatable :: unknowns(:)
    !> [-] plastic strains and creep strains, shears as angles, and behind them the accumulated equivalent strain, at the
    !> integration points of all cells that flow; shape (7, n_points), not allocated where nothing flows
    real(rk), allocatable :: plastic(:, :)
    real(rk), allocatable :: creep(:, :)
    !> [length] slip since the last time in tangential rows, 0 in all others; shape (n_multipliers), not allocated without friction
    real(rk), allocatable :: slip(:)
    !> whether each contact slips, shape (n_contacts), not allocated without friction
    logical, allocatable :: slips(:)
    !> one of sig_lcp's methods, or answer_condensed; method_name gives its name
    integer :: method = 0
    !> one of sig_reasons
    integer :: reason = reason_bad_point
    !> with reason_bad_property: number of the material, 1-based among those of the part that flow, and of the property of its law;
    !> else 0
    integer :: flaw(2) = 0
    !> number of linear solves and pivots
    integer :: n_iterations = 0
    !> whether the point lies in the trained box; outside there is an answer, too
    logical :: is_inside_box = .false.
    !> [-] distance to the nearest training point, with each side of the box scaled to 1
    real(rk) :: distance = huge(1.0_rk)
    !> [-] largest violation of the contact conditions of the problem that was solved, relative to the terms of its row
    real(rk) :: residual = huge(1.0_rk)
    !> number of solutions of the reduced problem that two starts found, 0 without an answer; with 2 the forces are less reliable
    integer :: n_solutions = 0
    !> number of independent motions of bodies that only contact holds which no contact force holds at the point; if it is not 0,
    !> the displacement and the gaps of these bodies are one of many possible
    integer :: n_free_motions = 0
    !> [sqrt(force*length)] upper bound of the error of lambda in the norm of W; no_bound (-1) without one; huge if the error can be
    !> of any size
    real(rk) :: bound = no_bound
    !> [-] the bound over the size of the answer, which counts as at least a thousandth of the largest in training; no_bound without
    !> one
    real(rk) :: relative_bound = no_bound
    !> [sqrt(force*length)] upper bound of the error of the displacement in the norm of the stiffness; no_bound without one
    real(rk) :: displacement_bound = no_bound
    !> [-] displacement_bound over the size of the displacement, which counts as at least a thousandth of the largest in training;
    !> no_bound without one
    real(rk) :: relative_displacement_bound = no_bound
    !> [-] estimate of the error of the forces, relative to their size, in a part whose materials flow; it is no bound. no_bound
    !> without one
    real(rk) :: error_estimate = no_bound
    !> [force] forces before the correction by which the estimate was made, shape (n_multipliers); not allocated where nothing
    !> flows
    real(rk), allocatable :: raw_multipliers(:)
    !> values of the model's terms, shape (n_terms)
    real(rk), allocatable :: theta(:)
  contains
    procedure :: start
    procedure :: take_solution
    procedure :: take_all_forces
    procedure :: reserve_slips
    procedure :: take_bound
    procedure :: take_displacement_bound
    procedure :: drop_bounds
  end type answer_t

contains

  !> Starts an answer of one part of the model: `cluster`, `part` and `displacement_part` become this part, and the arrays hold
  !> zeros (is_active: false). All else gets its default: no solution (reason_bad_point), no bounds. Arrays that have the right size
  !> are not allocated again.
  pure subroutine start(self, cluster, n_terms, n_modes, n_rows, n_multipliers)
    class(answer_t), intent(inout) :: self
    !> part of the model, 1-based: a cluster or the fallback
    integer, intent(in) :: cluster
    integer, intent(in) :: n_terms
    !> number of modes of this part
    integer, intent(in) :: n_modes
    !> number of contact rows of this part
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_multipliers

    self%cluster = cluster
    self%part = cluster
    self%displacement_part = cluster
    self%row_cluster = 0
    call resize(self%theta, n_terms)
    call resize(self%coordinates, n_modes)
    call resize(self%multipliers_rid, n_rows)
    call resize(self%multipliers, n_multipliers)
    call resize(self%unknowns, n_multipliers)
    if (allocated(self%is_active)) then
      if (size(self%is_active) /= n_rows) deallocate (self%is_active)
    end if
    if (.not. allocated(self%is_active)) allocate (self%is_active(n_rows))
    self%is_active = .false.
    self%is_whole = .false.
    self%method = 0
    self%reason = reason_bad_point
    self%flaw = 0
    self%n_iterations = 0
    self%is_inside_box = .false.
    self%distance = huge(self%distance)
    self%residual = huge(self%residual)
    self%n_solutions = 0
    self%n_free_motions = 0
    call self%drop_bounds()
  end subroutine start

  !> Gives an array the size n and sets it to zero. It is allocated only if it is not allocated yet or has another size.
  pure subroutine resize(values, n)
    real(rk), allocatable, intent(inout) :: values(:)
    integer, intent(in) :: n

    if (allocated(values)) then
      if (size(values) /= n) deallocate (values)
    end if
    if (.not. allocated(values)) allocate (values(n))
    values = 0
  end subroutine resize

  !> Allocates slip and slips for all contacts, if they do not have their sizes already.
  pure subroutine reserve_slips(self, n_contacts)
    class(answer_t), intent(inout) :: self
    integer, intent(in) :: n_contacts

    call resize(self%slip, size(self%multipliers))
    if (allocated(self%slips)) then
      if (size(self%slips) /= n_contacts) deallocate (self%slips)
    end if
    if (.not. allocated(self%slips)) allocate (self%slips(n_contacts))
  end subroutine reserve_slips

  !> Copies reason and residual of `solution`, sets the method, and adds the iterations of `solution` to n_iterations. n_solutions
  !> becomes 1, or 0 without a solution (reason <= 0). The forces are not copied.
  pure subroutine take_solution(self, solution, method)
    class(answer_t), intent(inout) :: self
    type(lcp_solution_t), intent(in) :: solution
    !> one of sig_lcp's methods, or answer_condensed
    integer, intent(in) :: method

    self%method = method
    self%reason = solution%reason
    self%n_iterations = self%n_iterations + solution%n_iterations
    self%residual = solution%residual
    self%n_solutions = merge(1, 0, solution%reason > 0)
  end subroutine take_solution

  !> Marks `multipliers` as known for all contacts (is_whole). If multipliers_rid has the same size, the contact rows of the cluster
  !> are all contacts: then multipliers_rid becomes a copy of `multipliers`, and is_active is true where the force is above 0.
  pure subroutine take_all_forces(self)
    class(answer_t), intent(inout) :: self

    self%is_whole = .true.
    if (size(self%multipliers_rid) /= size(self%multipliers)) return
    self%multipliers_rid = self%multipliers
    self%is_active = self%multipliers > 0
  end subroutine take_all_forces

  !> Sets the bound, and the relative bound = bound / size_of_answer. The relative bound is 0 if the bound is 0. Else it is no_bound
  !> if size_of_answer is 0: no contact has a force that counts (those of anchors do not), neither here nor in training, so nothing
  !> is there to compare with. Both are huge if the given bound is above sqrt(huge) or not a number.
  pure subroutine take_bound(self, bound, size_of_answer)
    class(answer_t), intent(inout) :: self
    !> [sqrt(force*length)]
    real(rk), intent(in) :: bound
    !> [sqrt(force*length)] result of comparable_size
    real(rk), intent(in) :: size_of_answer

    call relate(bound, size_of_answer, self%bound, self%relative_bound)
  end subroutine take_bound

  !> Sets displacement_bound and relative_displacement_bound, by the rules of take_bound.
  pure subroutine take_displacement_bound(self, bound, size_of_field)
    class(answer_t), intent(inout) :: self
    !> [sqrt(force*length)]
    real(rk), intent(in) :: bound
    !> [sqrt(force*length)] result of comparable_size
    real(rk), intent(in) :: size_of_field

    call relate(bound, size_of_field, self%displacement_bound, self%relative_displacement_bound)
  end subroutine take_displacement_bound

  !> Sets all bounds to no_bound.
  pure subroutine drop_bounds(self)
    class(answer_t), intent(inout) :: self

    self%bound = no_bound
    self%relative_bound = no_bound
    self%displacement_bound = no_bound
    self%relative_displacement_bound = no_bound
    self%error_estimate = no_bound
  end subroutine drop_bounds

  !> Sets a bound and its relative bound, as take_bound says.
  pure subroutine relate(found, size_of_answer, bound, relative_bound)
    real(rk), intent(in) :: found
    real(rk), intent(in) :: size_of_answer
    real(rk), intent(out) :: bound
    real(rk), intent(out) :: relative_bound

    bound = huge(bound)
    relative_bound = huge(bound)
    ! this is true for a value that is not a number, too
    if (.not. found < sqrt(huge(bound))) return
    bound = found
    relative_bound = 0
    if (bound > 0) relative_bound = merge(bound / max(size_of_answer, tiny(bound)), no_bound, size_of_answer > 0)
    if (relative_bound > sqrt(huge(bound))) relative_bound = huge(bound)
  end subroutine relate

  !> Returns the size [sqrt(force*length)] by which the bound of an answer is divided: the answer's own size, but at least a
  !> thousandth of the largest size in training.
  pure real(rk) function comparable_size(size_of_forces, largest_size)
    !> [sqrt(force*length)] size of the forces, or of the displacement, of the answer
    real(rk), intent(in) :: size_of_forces
    !> [sqrt(force*length)] largest size of these in training
    real(rk), intent(in) :: largest_size
    real(rk), parameter :: smallest_share = 1.0e-3_rk

    comparable_size = max(size_of_forces, smallest_share * largest_size)
  end function comparable_size

  !> Returns a bound as text for tables: the number (csv_number), `inf` for a huge bound, `none` for a negative one (no_bound).
  pure function bound_text(bound) result(text)
    !> any bound of answer_t, absolute or relative
    real(rk), intent(in) :: bound
    character(:), allocatable :: text

    text = 'none'
    if (bound >= 0) text = csv_number(bound)
    if (bound >= huge(bound)) text = 'inf'
  end function bound_text

  !> Returns the name of a method for reports and tables: `active_set`, `block_pivoting`, `lemke`, `condensed`; `none` for 0.
  pure function method_name(method) result(name)
    !> answer_t%method
    integer, intent(in) :: method
    character(:), allocatable :: name

    name = 'condensed'
    if (method < answer_condensed) name = lcp_method_name(method)
  end function method_name
end module sig_answer
