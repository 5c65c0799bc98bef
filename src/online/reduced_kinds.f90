! SPDX-License-Identifier: BSD-3-Clause
!> The kinds of reduced models by their names: a new kind needs a file of its own and a line here.
module sig_reduced_kinds
  use sig_body_compliance, only: body_compliance_t
  use sig_condensed_model, only: condensed_model_t
  use sig_fixed_compliance, only: fixed_compliance_t
  use sig_inelastic_model, only: inelastic_model_t
  use sig_reduced, only: reduced_t
  use sig_reduced_hhr, only: reduced_hhr_t
  use sig_tied_compliance, only: tied_compliance_t
  implicit none(type, external)
  private
  public :: create_reduced, bodies_of, fixed_of

  character(*), parameter, public :: kind_names = 'condensed, hhr, inelastic, interpolated, tied'

contains

  !> Makes a reduced model without data, of the kind with this name (kind_names); it stays unallocated if the name is unknown.
  subroutine create_reduced(kind, reduced)
    character(*), intent(in) :: kind
    class(reduced_t), allocatable, intent(out) :: reduced
    type(condensed_model_t), allocatable :: condensed

    select case (kind)
    case ('condensed')
      allocate (condensed)
      allocate (fixed_compliance_t :: condensed%compliance)
    case ('hhr')
      allocate (reduced_hhr_t :: reduced)
    case ('inelastic')
      allocate (inelastic_model_t :: reduced)
    case ('interpolated')
      allocate (condensed)
      allocate (body_compliance_t :: condensed%compliance)
    case ('tied')
      allocate (condensed)
      allocate (tied_compliance_t :: condensed%compliance)
    case default
      return
    end select
    if (allocated(condensed)) call move_alloc(condensed, reduced)
  end subroutine create_reduced

  !> Returns a pointer to the compliance of a condensed model if it is a fixed one; otherwise null.
  function fixed_of(model) result(fixed)
    type(condensed_model_t), target, intent(inout) :: model
    type(fixed_compliance_t), pointer :: fixed

    fixed => null()
    select type (compliance => model%compliance)
    type is (fixed_compliance_t)
      fixed => compliance
    end select
  end function fixed_of

  !> Returns a pointer to the compliance of a condensed model if it is a sum over bodies; otherwise null.
  function bodies_of(model) result(bodies)
    type(condensed_model_t), target, intent(inout) :: model
    type(body_compliance_t), pointer :: bodies

    bodies => null()
    select type (compliance => model%compliance)
    type is (body_compliance_t)
      bodies => compliance
    end select
  end function bodies_of
end module sig_reduced_kinds
