! SPDX-License-Identifier: BSD-3-Clause
!> Writes the fields of the answers of predict for ParaView and signorom-post view.
module sig_predicted_fields
  use sig_answer, only: answer_t, no_bound
  use sig_deck_config, only: output_config_t
  use sig_errors, only: error_t, make_error
  use sig_field_query, only: field_query_t, why_no_fields
  use sig_field_writer, only: field_writer_t
  use sig_file_system, only: base_name, directory_of, make_directories
  use sig_kinds, only: rk
  use sig_online_model, only: online_model_t
  use sig_query, only: query_t
  implicit none(type, external)
  private
  public :: predicted_fields_t, fields_folder

  !> [-] error of a displacement in the norm of the stiffness above which predict warns
  real(rk), parameter, public :: large_error = 0.01_rk

  !> Call `create`, then `add` for each point, then `close`; without `close` there are no new files.
  type :: predicted_fields_t
    private
    logical :: is_used = .false.
    type(online_model_t), pointer :: online => null()
    type(query_t) :: query
    type(field_query_t) :: fields
    type(field_writer_t) :: writer
    type(answer_t) :: answer
    !> number of points so far, with and without fields
    integer, public :: n_written = 0
    integer, public :: n_left_out = 0
    !> number of points with fields at which no contact force holds a body, and the first of these points
    integer, public :: n_unheld = 0
    real(rk), allocatable, public :: first_unheld(:)
    !> [-] largest relative_displacement_bound of the points with fields, negative if none has one; the point, and the number of
    !> points where it is above large_error
    real(rk), public :: largest_bound = no_bound
    real(rk), allocatable, public :: worst(:)
    integer, public :: n_inaccurate = 0
  contains
    procedure :: create
    procedure :: add
    procedure :: close => close_fields
  end type predicted_fields_t

contains

  !> Returns the folder of the fields: beside the table, with its name without ending and `_fields` (`a/b_fields` for `a/b.csv`), or
  !> `predicted_fields` beside the model if the table goes to the terminal.
  pure function fields_folder(model_path, output) result(folder)
    character(*), intent(in) :: model_path
    !> path of the table; empty = the terminal
    character(*), intent(in) :: output
    character(:), allocatable :: folder

    folder = directory_of(model_path) // '/predicted_fields'
    if (output /= '') folder = directory_of(output) // '/' // base_name(output) // '_fields'
  end function fields_folder

  !> Makes the folder if it is missing, and starts the files in it. Keeps a pointer to the model, which must stay until close.
  !> Errors: why_no_fields has a reason; the model cannot answer; the folder or the files cannot be created.
  subroutine create(self, online, model_path, folder, error)
    class(predicted_fields_t), intent(inout) :: self
    !> prepared
    type(online_model_t), intent(in), target :: online
    !> for messages
    character(*), intent(in) :: model_path
    character(*), intent(in) :: folder
    type(error_t), allocatable, intent(out) :: error
    type(output_config_t) :: everything
    character(:), allocatable :: message

    message = why_no_fields(online%model)
    if (message /= '') then
      call make_error(error, message, model_path)
      return
    end if
    call self%query%create(online, message)
    if (.not. allocated(message)) call self%fields%create(online, message)
    if (allocated(message)) then
      call make_error(error, 'the model cannot answer: ' // message, model_path)
      return
    end if
    self%online => online
    self%is_used = .true.
    call make_directories(folder, error)
    if (allocated(error)) return
    call self%writer%create(online%model, everything, folder, error)
  end subroutine create

  !> Adds the fields of a point. A point without an answer, or where Hooke's matrix or an imposed strain is not finite, has none and
  !> is counted in n_left_out. Does nothing without create.
  subroutine add(self, point)
    class(predicted_fields_t), intent(inout) :: self
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    logical :: is_valid

    if (.not. self%is_used) return
    call self%query%continue(self%online, point, self%answer)
    is_valid = self%answer%reason > 0
    if (is_valid) call self%fields%evaluate(self%online, point, self%answer, is_valid)
    if (.not. is_valid) then
      self%n_left_out = self%n_left_out + 1
      return
    end if
    self%n_written = self%n_written + 1
    if (self%answer%n_free_motions > 0) then
      if (self%n_unheld == 0) self%first_unheld = point
      self%n_unheld = self%n_unheld + 1
    end if
    call note_bound(self, point)
    call self%writer%start_point(self%online%model, point)
    call self%writer%write_values(self%online%model, self%fields%values, .true.)
  end subroutine add

  !> Takes the bound of the displacement's error at a point into largest_bound, worst and n_inaccurate.
  subroutine note_bound(self, point)
    type(predicted_fields_t), intent(inout) :: self
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)

    associate (bound => self%answer%relative_displacement_bound)
      if (bound > large_error) self%n_inaccurate = self%n_inaccurate + 1
      if (bound <= self%largest_bound) return
      self%largest_bound = bound
      self%worst = point
    end associate
  end subroutine note_bound

  !> Closes the files, which then get their names. If there is an error already, the error stays and there are no new files. Does
  !> nothing without create. Errors: the first failure since create.
  subroutine close_fields(self, error)
    class(predicted_fields_t), intent(inout) :: self
    type(error_t), allocatable, intent(inout) :: error

    if (.not. self%is_used) return
    if (.not. allocated(error)) call self%writer%close(error)
    call self%query%destroy()
    call self%fields%destroy()
  end subroutine close_fields
end module sig_predicted_fields
