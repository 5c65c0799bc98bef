! SPDX-License-Identifier: BSD-3-Clause
!> Fields of an answer: displacement, stresses, contact, at all cells and nodes.
module sig_field_query
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_answer, only: answer_t
  use sig_field_map, only: field_values_t
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_online_model, only: online_model_t
  use sig_reconstruction, only: fill_displacement, reconstruct_multipliers
  use sig_reduced, only: displacement_none
  use sig_rooms, only: rooms_t
  use sig_term_values, only: term_values_t
  implicit none(type, external)
  private
  public :: field_query_t, why_no_fields

  !> Queries for fields: call create, then evaluate for each point. One per thread.
  type :: field_query_t
    private
    type(term_values_t) :: terms
    real(rk), allocatable :: theta(:)
    real(rk), allocatable :: displacement(:)
    real(rk), allocatable :: multipliers(:)
    type(rooms_t) :: rooms
    type(field_values_t), public :: values
  contains
    procedure :: create
    procedure :: evaluate
    procedure :: destroy
  end type field_query_t

contains

  !> Returns a sentence that says why a model gives no fields and what to change in the deck: it keeps no mesh, or a cluster has no
  !> displacement of some dof. The fallback does not count. The result is empty if the model gives fields. Requires: complete_model.
  pure function why_no_fields(model) result(reason)
    type(model_t), intent(in) :: model
    character(:), allocatable :: reason
    logical :: has_all
    integer :: i, k

    reason = 'the model keeps no mesh for fields: train it with reduction.fields: true in the deck'
    if (.not. model%fields%is_there()) return
    reason = ''
    has_all = .true.
    do i = 1, model%n_clusters()
      associate (part => model%parts(i)%reduced)
        has_all = has_all .and. part%has_displacement() .and. &
          all([(part%displacement_source(k) /= displacement_none, k=1, model%n_dofs)])
      end associate
    end do
    if (.not. has_all) reason = 'the model does not have the displacements of all nodes, which fields need: train it with ' // &
      'reduction.displacement: auto, or elsewhere: modes; where the matrix of all contacts is too large (kind tied), with a ' // &
      'larger reduction.max_full_order_size'
  end function why_no_fields

  !> Prepares the queries of one thread: compiles the expressions and allocates the arrays. Errors: message is allocated if an
  !> expression of an elastic constant or of an imposed strain is not valid.
  subroutine create(self, online, message)
    class(field_query_t), intent(inout) :: self
    !> the model, after prepare; it gives fields (why_no_fields)
    type(online_model_t), intent(in) :: online
    character(:), allocatable, intent(out) :: message

    call self%destroy()
    call self%terms%create(online%model%fields%terms, message)
    if (allocated(message)) return
    allocate (self%theta(online%model%fields%terms%n_terms()), self%displacement(online%model%n_dofs), &
      self%multipliers(online%model%n_multipliers))
  end subroutine create

  !> Computes the fields of an answer in `values`. is_valid is false, and `values` does not change, if an elastic constant or an
  !> imposed strain has no finite value or Hooke's matrix is not finite. This may happen far outside of the trained box.
  subroutine evaluate(self, online, point, answer, is_valid)
    class(field_query_t), intent(inout) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> values of the parameters, shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> answer at this point, with a solution
    type(answer_t), intent(in) :: answer
    logical, intent(out) :: is_valid
    integer :: i_source

    call self%terms%evaluate(point, self%theta, is_valid, i_source)
    if (.not. is_valid) return
    associate (map => online%model%fields)
      is_valid = all(ieee_is_finite(map%laws(self%theta)))
      if (.not. is_valid) return
      call fill_displacement(online%model, answer, self%displacement)
      call reconstruct_multipliers(online, answer, self%rooms, self%multipliers)
      call self%values%take_displacement(map, self%displacement)
      call self%values%take_contact(map, online%model%laws, answer%theta, self%multipliers)
      if (allocated(answer%slip)) call self%values%take_friction(map, self%multipliers, answer%slip, answer%slips)
      ! those that are not allocated count as not present
      call self%values%take_flow(map, answer%plastic, answer%creep)
      call self%values%take_stresses(map, self%theta)
    end associate
  end subroutine evaluate

  !> Frees the expressions and the arrays, but not `values`; it may be called without create.
  subroutine destroy(self)
    class(field_query_t), intent(inout) :: self

    call self%terms%destroy()
    if (allocated(self%theta)) deallocate (self%theta, self%displacement, self%multipliers)
    if (allocated(self%rooms%of_part)) deallocate (self%rooms%of_part)
  end subroutine destroy
end module sig_field_query
