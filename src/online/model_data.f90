! SPDX-License-Identifier: BSD-3-Clause
!> What all data have that come in several kinds and that a model file keeps in a group of their own: reduced models, and where a
!> condensed one has its compliance from. They have contact rows, and say what displacement belongs to an answer.
module sig_model_data
  use sig_answer, only: answer_t
  use sig_contact_laws, only: contact_laws_t
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: model_data_t, model_sizes_t

  !> Sizes of the model that the data belong to.
  type :: model_sizes_t
    integer :: n_dofs = 0
    integer :: n_multipliers = 0
    integer :: n_terms = 0
    !> number of training points
    integer :: n_points = 0
    !> friction and ties of the contacts; without arrays: none
    type(contact_laws_t) :: laws
  end type model_sizes_t

  type, abstract :: model_data_t
  contains
    procedure(text_of), deferred :: kind
    procedure(complete_for), deferred :: complete
    procedure(find_mismatch), deferred :: mismatch
    procedure(write_to), deferred :: write
    procedure(read_from), deferred :: read
    procedure(text_of), deferred :: describe
    procedure(size_of), deferred :: n_rows
    procedure(fill_all), deferred :: fill_displacement
    procedure(dof_value), deferred :: displacement_of_dof
  end type model_data_t

  abstract interface
    !> `kind` returns the name of the kind as in model files, `describe` lines for people, each with its line end.
    pure function text_of(self) result(text)
      import :: model_data_t
      implicit none(type, external)
      class(model_data_t), intent(in) :: self
      character(:), allocatable :: text
    end function text_of

    !> Allocates the arrays that are not allocated, with size 0 or without values.
    pure subroutine complete_for(self, sizes)
      import :: model_data_t, model_sizes_t
      implicit none(type, external)
      class(model_data_t), intent(inout) :: self
      type(model_sizes_t), intent(in) :: sizes
    end subroutine complete_for

    !> Returns the name of an array whose shape does not fit the model, or whose values a query cannot use; empty when all fit.
    !> Requires: complete.
    pure function find_mismatch(self, sizes) result(name)
      import :: model_data_t, model_sizes_t
      implicit none(type, external)
      class(model_data_t), intent(in) :: self
      type(model_sizes_t), intent(in) :: sizes
      character(:), allocatable :: name
    end function find_mismatch

    !> Writes the data to a group of a model file. A failure of the file is reported when the file is closed.
    subroutine write_to(self, file, group, length, force)
      import :: h5_writer_t, model_data_t
      implicit none(type, external)
      class(model_data_t), intent(in) :: self
      type(h5_writer_t), intent(inout) :: file
      character(*), intent(in) :: group
      !> names of the units
      character(*), intent(in) :: length
      character(*), intent(in) :: force
    end subroutine write_to

    !> Reads the data from a group of a model file. Errors: a dataset or attribute is missing, or has another type or rank.
    subroutine read_from(self, file, group, error)
      import :: error_t, h5_reader_t, model_data_t
      implicit none(type, external)
      class(model_data_t), intent(inout) :: self
      type(h5_reader_t), intent(in) :: file
      character(*), intent(in) :: group
      type(error_t), allocatable, intent(inout) :: error
    end subroutine read_from

    !> Returns the number of contact rows whose forces an answer has without reconstruction; anchors count, too.
    pure integer function size_of(self)
      import :: model_data_t
      implicit none(type, external)
      class(model_data_t), intent(in) :: self
    end function size_of

    !> Computes the displacement of all dofs; it is NaN for dofs of which there is none.
    subroutine fill_all(self, answer, displacement)
      import :: answer_t, model_data_t, rk
      implicit none(type, external)
      class(model_data_t), intent(in) :: self
      type(answer_t), intent(in) :: answer
      !> [length] shape (n_dofs)
      real(rk), contiguous, intent(inout) :: displacement(:)
    end subroutine fill_all

    !> Returns the displacement [length] of one dof, without a temporary array; NaN if there is none of this dof.
    pure real(rk) function dof_value(self, answer, dof)
      import :: answer_t, model_data_t, rk
      implicit none(type, external)
      class(model_data_t), intent(in) :: self
      type(answer_t), intent(in) :: answer
      !> 1-based
      integer, intent(in) :: dof
    end function dof_value
  end interface
end module sig_model_data
