! SPDX-License-Identifier: BSD-3-Clause
!> Answers a block of points by several threads, and makes the lines of the table of predict in the order of the points.
module sig_answer_block
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_funloc, c_funptr, c_int, c_loc, c_ptr
  use sig_force_columns, only: force_columns, force_values
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_reasons, only: reason_length
  use sig_rooms, only: rooms_t
  use sig_online_model, only: online_model_t
  use sig_answer, only: answer_t, bound_text, method_name, n_answer_methods, no_bound
  use sig_query, only: query_t
  use sig_reconstruction, only: reconstruct_multipliers
  use sig_signals, only: is_stop_requested
  use sig_text, only: join, to_text
  implicit none(type, external)
  private
  public :: answer_block_t, table_header

  !> The data of one thread.
  type :: asker_t
    type(query_t) :: query
    type(answer_t) :: answer
    type(rooms_t) :: rooms
    !> number of points that each method answered, 0 = without an answer; shape (0:n_answer_methods)
    integer, allocatable :: counts(:)
    !> number of points where the reduced problem has several solutions
    integer :: n_several = 0
    !> [-] largest error_estimate, no_bound without one
    real(rk) :: largest_estimate = no_bound
  end type asker_t

  !> Call create; then set points and n_points, call answer and line for each block; then destroy.
  type :: answer_block_t
    type(online_model_t), pointer :: online => null()
    type(asker_t), allocatable :: askers(:)
    !> the caller sets the points, the first columns, and their number; shape (n_parameters, capacity)
    real(rk), allocatable :: points(:, :)
    integer :: n_points = 0
    !> [force] of all contacts, shape (n_multipliers, capacity)
    real(rk), allocatable :: multipliers(:, :)
    !> [length] slip since the last time, shape (n_multipliers, capacity), and whether each contact slips, shape (n_contacts,
    !> capacity); zero and false without friction
    real(rk), allocatable :: slip(:, :)
    logical, allocatable :: slips(:, :)
    !> why points have no answer, shape (capacity)
    character(reason_length), allocatable :: refusals(:)
    !> these components of the answers, shape (capacity). methods: 0 without an answer; bounds, estimates: [-], negative without
    !> one; is_outside: the point is outside of the trained box
    integer, allocatable :: clusters(:)
    integer, allocatable :: methods(:)
    integer, allocatable :: reasons(:)
    integer, allocatable :: n_solutions(:)
    real(rk), allocatable :: bounds(:)
    real(rk), allocatable :: displacement_bounds(:)
    real(rk), allocatable :: estimates(:)
    logical, allocatable :: is_outside(:)
  contains
    procedure :: create
    procedure :: answer => answer_points
    procedure :: counts
    procedure :: largest_estimate
    procedure :: line
    procedure :: destroy
  end type answer_block_t

  ! include/signorom/threads.h describes this procedure in C.
  interface
    subroutine sig_run_threads(n, work, data) bind(c)
      import :: c_funptr, c_int, c_ptr
      integer(c_int), value :: n
      type(c_funptr), value :: work
      type(c_ptr), value :: data
    end subroutine sig_run_threads
  end interface

contains

  !> Prepares a block for up to `capacity` points at a time, with data of its own for each of the n_threads threads (1 or more).
  !> Keeps a pointer to the model, which must stay until destroy. Errors: message is allocated if the expressions of the model's
  !> terms cannot be evaluated. Requires: a new block.
  subroutine create(self, online, n_threads, capacity, message)
    class(answer_block_t), intent(inout) :: self
    !> prepared
    type(online_model_t), intent(in), target :: online
    integer, intent(in) :: n_threads
    integer, intent(in) :: capacity
    character(:), allocatable, intent(out) :: message
    integer :: i

    self%online => online
    allocate (self%askers(n_threads), self%points(size(online%model%parameter_names), capacity))
    allocate (self%multipliers(online%model%n_multipliers, capacity), self%clusters(capacity))
    allocate (self%slip(online%model%n_multipliers, capacity), source=0.0_rk)
    allocate (self%slips(online%model%laws%n_contacts, capacity), source=.false.)
    allocate (self%methods(capacity), self%reasons(capacity), self%refusals(capacity), &
      self%n_solutions(capacity), self%bounds(capacity), &
      self%displacement_bounds(capacity), self%estimates(capacity), self%is_outside(capacity))
    do i = 1, n_threads
      allocate (self%askers(i)%counts(0:n_answer_methods), source=0)
      call self%askers(i)%query%create(online, message)
      if (allocated(message)) return
      call self%askers(i)%query%leave_out_points()
    end do
  end subroutine create

  !> Answers points(:, :n_points) by all threads and sets the components from multipliers to is_outside. The multipliers of a point
  !> without an answer are 0. After a signal the points that no thread has begun are left out: their values keep what they had
  !> before.
  subroutine answer_points(self)
    class(answer_block_t), intent(inout), target :: self
    type(answer_block_t), pointer :: whole

    select type (self)
    type is (answer_block_t)
      whole => self
      call sig_run_threads(int(size(self%askers), c_int), c_funloc(answer_share), c_loc(whole))
    end select
  end subroutine answer_points

  !> Answers every n-th point of the block, beginning with point i_thread_0 + 1, so that difficult neighbors are shared between the
  !> n threads; where the states of a history remember, every n-th history. Stops at a signal. `data` is the address of the block.
  !> Recursive, because several threads run it at once.
  !>
  !> It makes no texts: gfortran 12 keeps the lengths of the results of text functions in static variables.
  recursive subroutine answer_share(i_thread_0, data) bind(c) ! lint: callback
    integer(c_int), value :: i_thread_0
    type(c_ptr), value :: data
    type(answer_block_t), pointer :: self
    integer :: i, i_share, n_each

    call c_f_pointer(data, self)
    n_each = 1
    if (self%online%model%remembers()) n_each = max(1, self%online%model%history%n_times())
    associate (asker => self%askers(i_thread_0 + 1))
      do i = 1, self%n_points
        i_share = (i - 1) / n_each
        if (modulo(i_share, size(self%askers)) /= i_thread_0) cycle
        if (is_stop_requested()) exit
        call asker%query%continue(self%online, self%points(:, i), asker%answer)
        self%is_outside(i) = .not. asker%answer%is_inside_box
        call reconstruct_multipliers(self%online, asker%answer, asker%rooms, self%multipliers(:, i))
        if (allocated(asker%answer%slip) .and. asker%answer%reason > 0) then
          self%slip(:, i) = asker%answer%slip
          self%slips(:, i) = asker%answer%slips
        end if
        self%clusters(i) = asker%answer%cluster
        self%methods(i) = merge(asker%answer%method, 0, asker%answer%reason > 0)
        self%reasons(i) = asker%answer%reason
        if (asker%answer%reason <= 0) call self%online%model%parts(asker%answer%part)%reduced%put_refusal(asker%answer, &
          self%refusals(i))
        self%n_solutions(i) = asker%answer%n_solutions
        self%bounds(i) = asker%answer%relative_bound
        self%displacement_bounds(i) = asker%answer%relative_displacement_bound
        self%estimates(i) = asker%answer%error_estimate
        asker%largest_estimate = max(asker%largest_estimate, asker%answer%error_estimate)
        asker%counts(self%methods(i)) = asker%counts(self%methods(i)) + 1
        if (asker%answer%n_solutions > 1) asker%n_several = asker%n_several + 1
      end do
    end associate
  end subroutine answer_share

  !> Returns how many points each method has answered so far, in all blocks, at the index of its number (answer_t%method); counts(0)
  !> is the number of points without an answer. Requires: create.
  pure function counts(self)
    class(answer_block_t), intent(in) :: self
    integer :: counts(0:n_answer_methods)
    integer :: i

    counts = 0
    do i = 1, size(self%askers)
      counts = counts + self%askers(i)%counts
    end do
  end function counts

  !> Returns the largest error_estimate [-] of all answers so far, in all blocks; no_bound if none has one. Requires: create.
  pure real(rk) function largest_estimate(self)
    class(answer_block_t), intent(in) :: self

    largest_estimate = maxval(self%askers%largest_estimate)
  end function largest_estimate

  !> Frees the memory. Harmless if the block was never created.
  subroutine destroy(self)
    class(answer_block_t), intent(inout) :: self
    integer :: i

    if (.not. allocated(self%askers)) return
    do i = 1, size(self%askers)
      call self%askers(i)%query%destroy()
    end do
    deallocate (self%askers, self%points, self%multipliers, self%slip, self%slips, self%clusters, self%methods, self%reasons, &
      self%refusals, self%n_solutions, self%bounds, self%displacement_bounds, self%estimates, self%is_outside)
  end subroutine destroy

  !> Returns the head of the table, without a line end: the names of the parameters, cluster, next_cluster (only with several
  !> clusters), status, solver, n_solutions, error_bound, displacement_bound, error_estimate (only where materials flow), n_active,
  !> contact_force (the sum over all rows), those of contact_columns, and lambda_<number>, the contact force of each row. The number
  !> is that of the row's owner (its first node) in the mesh file. Commas stand between the columns.
  function table_header(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(model%parameter_names)
      text = text // model%parameter_names(i)%text // ','
    end do
    text = text // 'cluster,'
    if (model%n_clusters() > 1) text = text // 'next_cluster,'
    text = text // 'status,solver,n_solutions,error_bound,displacement_bound,'
    if (model%has_estimates()) text = text // 'error_estimate,'
    text = text // force_columns(model)
  end function table_header

  !> Returns the line of the table for point i of the block, 1-based, without a line end. Without an answer, status is the reason in
  !> quotes, solver is `none`, and n_active, the contact forces and the values of contact_values are `nan`. Requires: answer has
  !> answered the point.
  function line(self, i) result(text)
    class(answer_block_t), intent(in) :: self
    integer, intent(in) :: i
    character(:), allocatable :: text

    text = join(self%points(:, i), ',') // ',' // to_text(self%clusters(i)) // ','
    if (self%online%model%n_clusters() > 1) text = text // &
      to_text(self%online%model%choice%next_cluster(self%points(:, i))) // ','
    if (self%reasons(i) > 0) then
      text = text // 'answered,'
    else
      text = text // '"' // trim(self%refusals(i)) // '",'
    end if
    text = text // method_name(self%methods(i)) // ',' // to_text(self%n_solutions(i)) // ',' // &
      bound_text(self%bounds(i)) // ',' // bound_text(self%displacement_bounds(i)) // ','
    if (self%online%model%has_estimates()) text = text // bound_text(self%estimates(i)) // ','
    text = text // force_values(self%online%model, self%multipliers(:, i), self%slip(:, i), self%slips(:, i), &
      self%reasons(i) > 0)
  end function line
end module sig_answer_block
